// The geodesic between two poses, as `skpose.geodesic` finds it: a path of least energy, from a straight line on.
//
// Gauss-Newton steps on block-tridiagonal normal equations, damped as in a trust region and combined by conjugate
// gradients. Few poses can sit where their chords are short while the motion between them is long: so each path is
// measured again on a fine grid, and refined where the lengths disagree.

// Damping is relative to the mean diagonal of the normal equations.
const DAMPING = { first: 1e-6, least: 1e-8, most: 1e6 };
const ROUNDING = 1e-14; // relative to the energy or to the sum of the bones
const FINE = 8; // chords into which each chord is divided to measure a path again
const MOST_GAP = 5e-3; // relative difference of the two lengths of a path that is not refined
const DIVERGED = 4; // a path is given up whose gap is so many times larger
const PATIENCE = 10; // iterations after which that is asked
const MOST_ITERATIONS = 200; // of each refinement
const GAIN = 1e-6; // relative decrease of the energy, twice that of the length, that a step must promise
const FLAT = 1e-4; // curvature that counts as none, relative to the mean diagonal
const AGREE = 1e-6; // relative difference of chord and line within which the line is the geodesic
const REFINEMENTS = [[1, 1], [1, 4], [2, 4], [4, 4]]; // free steps over chords, chords in each
const PAUSE = 12; // ms of computing after which events of the page are served

/** Let the page serve its events, if it could not for some time. */
class Breaks {
  last = performance.now();

  /** `isStopped()` is whether nobody waits for the result any more. */
  constructor(isStopped) {
    this.isStopped = isStopped;
  }

  async take() {
    if (this.isStopped()) throw new Error("the search was stopped");
    if (performance.now() - this.last < PAUSE) return;
    await new Promise((resume) => setTimeout(resume));
    this.last = performance.now();
  }
}

/**
 * Find the geodesic between two poses: its length as `pose_distances` has it, m, never shorter than "position" nor
 * longer than "spatial"; poses along it from a to b; and whether it is a minimum that passes the check.
 *
 * `refined` are the refinements that may be tried: how many times more steps than `chords`, and chords in each. The
 * search throws an error once `isStopped()`.
 */
async function geodesic(skeleton, a, b, { chords: nChords = 10, refined = REFINEMENTS, isStopped = () => false } = {}) {
  const ahead = isAhead(skeleton, a, b); // so that both directions give one number
  const chart = ahead ? new Chart(skeleton, a, b) : new Chart(skeleton, b, a);
  const straight = straightLine(skeleton, a, b, nChords);
  const position = chord(skeleton, skeleton.positions(a), skeleton.positions(b));
  const lines = [chart.slerpLine(nChords), chart.straightLine(nChords)].filter(Boolean);
  const lengths = lines.map((line) => chords(chart, line).length);
  const most = Math.min(...lengths, lengthOf(skeleton, straight));
  const line = lines[lengths[1] < lengths[0] ? 1 : 0];
  let found = { nodes: line, length: most, converged: true };
  if (most - position > AGREE * most + roundingLength(skeleton)) {
    found = await leastPath(chart, line, refined, new Breaks(isStopped));
  }
  const poses = [a];
  for (const node of (ahead ? found.nodes : found.nodes.reverse()).slice(1)) poses.push(chart.pose(node, poses.at(-1)));
  return { length: Math.max(position, Math.min(found.length, most)), poses, converged: found.converged };
}

/** Whether the first column in which two poses differ is larger in the second. */
function isAhead(skeleton, a, b) {
  for (let d = 0; d < skeleton.width; d++) {
    const gap = skeleton.angles[d] ? wrapped(b[d]) - wrapped(a[d]) : b[d] - a[d];
    if (gap) return gap > 0;
  }
  return true;
}

/** A length below which only rounding is left. */
function roundingLength({ joints }) {
  let reach = 0;
  for (const { offset: [x, y, z] } of joints) reach += Math.abs(x) + Math.abs(y) + Math.abs(z);
  return ROUNDING * reach * Math.sqrt(Math.max(...joints.map(({ weight }) => weight)));
}

/** A path of least energy that passes the check, from a line on; where there is none, the line, not converged. */
async function leastPath(chart, line, refined, breaks) {
  const noise = roundingLength(chart.skeleton);
  let nodes = line;
  let factor = 1;
  for (const [times, substeps] of refined) {
    if (substeps > 1) nodes = times === 1 ? line : divided(nodes, times / factor);
    factor = times;
    const { path, converged } = await minimise(new Path(chart, nodes, substeps), breaks);
    nodes = path.nodes;
    const { length } = chords(chart, path.samples);
    const along = curveLength(chart, path.samples, FINE);
    await breaks.take();
    const parts = (FINE * (path.samples.length - 1)) / (line.length - 1);
    if (along - length <= MOST_GAP * along + noise && along <= chords(chart, divided(line, parts)).length + noise) {
      return { nodes: path.samples, length, converged };
    }
  }
  return { nodes: line, length: chords(chart, line).length, converged: false };
}

/** Minimise the energy of a path; returns the path of least energy so far, and whether it is a minimum. */
async function minimise(path, breaks) {
  const { chart } = path;
  const solve = (equations, damping) => solveBand(equations, chart.branches, chart.width, damping);
  let [scale, damping, perturbed] = [0, 0, 0];
  let [slopeBefore, stepBefore, direction] = [0, null, null];
  for (let iteration = 0; iteration < MOST_ITERATIONS; iteration++) {
    await breaks.take();
    const equations = path.equations();
    if (!iteration) {
      scale = meanDiagonal(equations, chart.width);
      damping = DAMPING.first * scale;
    }
    if (scale <= roundingLength(chart.skeleton) ** 2) return { path, converged: true }; // nothing moves
    let [used, step] = [damping, null];
    while (!step && used < DAMPING.most * scale) {
      step = solve(equations, used);
      if (!step) used = Math.max(10 * used, DAMPING.first * scale);
    }
    if (!step) return { path, converged: false };
    const slope = -total(equations.gradient, step);
    const predicted = (used * total(step, step) + slope) / 2;
    if (predicted <= GAIN * path.half) {
      if (used > scale) return { path, converged: false }; // it is the damping that leaves no step
      path.addSecondDerivatives(equations);
      if (perturbed === 2 || solve(equations, FLAT * scale)) return { path, converged: true };
      perturbed++; // a saddle
      path = path.moved(perturbation(path), 1);
      [slopeBefore, damping] = [0, DAMPING.first * scale];
      continue;
    }
    // Combined as Polak and Ribière do.
    const share = slopeBefore > 0 ? (slope + total(equations.gradient, stepBefore)) / slopeBefore : 0;
    direction = combined(step, Math.min(Math.max(share, 0), 2), direction);
    if (total(equations.gradient, direction) >= 0) direction = step;
    const trial = searched(path, direction, -total(equations.gradient, direction));
    const ratio = (path.half - trial.half) / predicted;
    if (ratio > 1e-4) {
      path = trial;
      stepBefore = step;
    }
    slopeBefore = ratio > 0.25 ? slope : 0;
    if (ratio > 0.75) damping = Math.max(0.1 * damping, DAMPING.least * scale);
    else if (ratio < 0.25) damping *= 4;
    const isDue = path.substeps === 1 && iteration % PATIENCE === PATIENCE - 1;
    if (isDue && diverged(path)) return { path, converged: false };
  }
  return { path, converged: false };
}

/** Σ a·b over all but the ends. */
function total(a, b) {
  let sum = 0;
  for (let i = 1; i < a.length - 1; i++) sum += rowProduct(a[i], 0, b[i], 0, a[i].length);
  return sum;
}

const combined = (step, share, direction) =>
  share ? step.map((row, i) => row.map((value, d) => value + share * direction[i][d])) : step;

/** The mean of the diagonal over the free nodes. */
function meanDiagonal({ diagonal }, width) {
  let sum = 0;
  for (const block of diagonal.slice(1, -1)) for (let d = 0; d < width; d++) sum += block[width * d + d];
  return sum / ((diagonal.length - 2) * width);
}

/** The path at the whole direction, or at the minimum of the parabola through energy, slope and that one: the lower. */
function searched(path, direction, descent) {
  const first = path.moved(direction, 1);
  const curvature = 2 * (first.half - path.half + descent);
  const size = curvature > 0 ? descent / curvature : 1;
  if (Math.abs(size - 1) <= 0.1 || size >= 4) return first;
  const second = path.moved(direction, size);
  return second.half < first.half ? second : first;
}

/** A small step of the free nodes in no direction that a symmetry would have, rad. */
function perturbation({ nodes }) {
  return nodes.map((node, i) =>
    node.map((_, d) => 1e-2 * Math.sin((Math.PI * i) / (nodes.length - 1)) * Math.cos(1 + d * d)));
}

/** Whether a path is much longer between its nodes than by its chords. */
function diverged({ chart, nodes }) {
  const along = chords(chart, divided(nodes, FINE)).length;
  return along - chords(chart, nodes).length > DIVERGED * MOST_GAP * along;
}
