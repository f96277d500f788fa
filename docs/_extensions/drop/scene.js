// Motions in space, as the player draws them: what skpose/view/_scene.py and _ground.py do.

// For each axis that points up which axes of the world are x, y and z here, and numbers of find_ground and link_shape.
const { axes: AXES, ground: GROUND, link: LINK } = data.constants;
const STEP = 5e-5; // m or rad, to which numbers are rounded

function percentileOf(values, percent) {
  const sorted = Float64Array.from(values).sort();
  const at = ((sorted.length - 1) * percent) / 100;
  const below = Math.floor(at);
  return sorted[below] + (at - below) * ((sorted[below + 1] ?? sorted[below]) - sorted[below]);
}

/** The height of the ground below points, and the number of frames that it is from: `find_ground`. */
function findGround(frames, rate, size) {
  const lowest = frames.map((points) => points.reduce((best, point, i) => (point[1] < points[best][1] ? i : best), 0));
  const heights = frames.map((points, f) => points[lowest[f]][1]);
  const step = frames.length > 1 ? 1 / rate : Infinity;
  const k = Math.max(1, Math.round(Math.min(GROUND.window / step, frames.length)));
  const stands = frames.map((_, f) => {
    const [before, after] = [Math.max(f - k, 0), Math.min(f + k, frames.length - 1)];
    const [a, b] = [before, after].map((frame) => frames[frame][lowest[f]]);
    const moved = Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    return moved < (GROUND.slow * size * (after - before)) / rate;
  });
  for (let first = 0; first < stands.length; first++) {
    if (!stands[first]) continue;
    let end = first;
    while (stands[end]) end++;
    if ((end - first) * step < GROUND.short) stands.fill(false, first, end);
    first = end;
  }
  const standing = heights.filter((_, f) => stands[f]);
  if (!standing.length) return { height: Math.min(...heights), frames: 0 };
  const limit = percentileOf(standing, GROUND.low) + GROUND.level * size;
  return { height: percentileOf(standing.filter((height) => height <= limit), 50), frames: standing.length };
}

/** Positions of the joints about the root, and of the root, y up, m; and the rest of what a page has of a motion. */
function sceneOf({ skeleton, poses, positions, orientations, rate }, up) {
  const kinematics = new Skeleton(skeleton);
  const order = AXES[up];
  const turned = (point) => order.map((axis) => point[axis]);
  const root = positions.map(turned);
  const joints = poses.map((pose, f) => {
    const at = kinematics.positions(pose);
    return skeleton.names.map((_, j) => turned(rotations.apply(orientations[f], [...at.subarray(3 * j, 3 * j + 3)])));
  });
  const sizeOf = (frame) => Math.max(...[0, 1, 2].map((axis) => {
    const values = frame.map((point) => point[axis]);
    return Math.max(0, ...values) - Math.min(0, ...values);
  }));
  const size = sizeOf(joints[0]) || Math.max(...joints.map(sizeOf)) || 1;
  const moved = (at, f) => at.map((value, axis) => value + root[f][axis]);
  const placed = joints.map((frame, f) => [root[f], ...frame.map((at) => moved(at, f))]);
  const ground = findGround(placed, rate, size);
  const headings = orientations.map((q) => wrapped(2 * Math.atan2(q["xyz".indexOf(up) + 1], q[0])));
  for (const point of root) point[1] -= ground.height;
  return { joints, root, headings, axes: order.map((axis) => "xyz"[axis]).join(""), size, standing: ground.frames };
}

const shapeOf = (skeleton) => personShape(skeleton) ?? linkShape(skeleton);

/** Links for all bones: `link_shape` of skpose/view/_shape.py. */
function linkShape(skeleton) {
  const { names, parents, offsets } = skeleton;
  const still = positionsAtZero(skeleton);
  const extent = (axis) => {
    const values = [0, ...still.map((point) => point[axis])];
    return Math.max(...values) - Math.min(...values);
  };
  const size = Math.max(...[0, 1, 2].map(extent)) || 1;
  const lengths = offsets.map((offset) => Math.hypot(...offset));
  const own = lengths.map((length) =>
    (length > 1e-3 * size ? Math.min(LINK.thickest * size, LINK.ofLength * length + LINK.thinnest * size) : 0));
  const radii = new Array(names.length + 1).fill(0);
  own.forEach((width, j) => {
    for (const point of [j + 1, parents[j] + 1]) radii[point] = Math.max(radii[point], width);
  });
  radii[0] ||= Math.max(...radii, LINK.ofPoint * size);
  const without = names.map((_, j) => j).filter((j) => !own[j]);
  for (const j of [...[...without].reverse(), ...without]) { // points at one place are as thick as the thickest of them
    radii[j + 1] = radii[parents[j] + 1] = Math.max(radii[j + 1], radii[parents[j] + 1]);
  }
  const hulls = parents.map((parent, j) => (own[j] ? [parent + 1, j + 1] : [j + 1]));
  const points = [...new Set(hulls.flat())];
  const carries = new Set(parents.map((parent) => parent + 1));
  const spheres = points.map((point) => ({
    at: [point], radius: radii[point], ...(point > 0 && carries.has(point) ? { inside: true } : {}),
  }));
  return { spheres, parts: hulls.map((hull, j) => [j, [hull.map((point) => points.indexOf(point))]]) };
}

function motionData(motion, label, up) {
  const { skeleton, rate, poses } = motion;
  const scene = sceneOf(motion, up);
  return {
    label, names: skeleton.names, parents: skeleton.parents, sides: skeleton.sides, shape: shapeOf(skeleton),
    axes: scene.axes, size: scene.size, standing: scene.standing, rate, start: 0, numbers: null,
    error: 1e3 * Math.sqrt(3) * STEP, // half a step along each axis, of the joint and of the root
    headings: rounded(scene.headings.map((angle) => [angle])),
    joints: rounded(scene.joints.map((frame) => frame.flat())),
    root: rounded(scene.root),
    count: poses.length,
  };
}

/** Rows of numbers as `unpack` of page.js reads them, rounded to a step. */
const rounded = (rows) => ({ step: STEP, given: rows.map((row) => row.map((value) => Math.round(value / STEP))) });
