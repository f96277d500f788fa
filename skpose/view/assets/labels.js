// Where the labels of groups are: near their points, where few other points are, and none over another.

const RADII = [0, 50, 75, 100, 130, 165, 205, 250, 300, 360]; // px from the point to the middle of its label
const LEASH = 0.4; // of the canvas' shorter side
const ROUNDS = 3; // in which each is placed among all others
const DIRECTIONS = 16;
const POINT = 12; // px around a point that another line stays away from
const OCCUPIED = 12; // px of a cell that counts as occupied where it has a point
// What a place costs, px that the label might be farther away instead: where all of it is occupied, a line that crosses
// another one, a line over a label. Above the last one there is none.
const [HIDES, CROSSES, COVERS, DEAREST] = [230, 250, 250, 800];

/**
 * Place labels, `{ row, width, height }`, the first ones first, and again among all others; return those that have
 * room, with the `offset` of their middle from their point, px. None is over another at any zoom from a power of two to
 * the next one; where all of the plane is seen, all labels are inside.
 */
function placeLabels(scatter, labels, zoom) {
  const unit = (scatter.scale / scatter.zoom) * zoom;
  const { middle } = scatter;
  const occupied = occupiedCells(scatter, unit);
  const at = (row) => [unit * (scatter.x[row] - middle[0]), -unit * (scatter.y[row] - middle[1])];
  const most = LEASH * Math.min(scatter.width, scatter.height);
  const offsets = RADII.filter((radius) => radius <= most).flatMap((radius) =>
    (radius ? circle(DIRECTIONS) : [[0, 0]]).map((direction) => direction.map((share) => radius * share)));
  const home = (place) => [scatter.width / 2 + place[0], scatter.height / 2 + place[1]]; // where all is seen
  /** What the place of a label costs, without the others. */
  const costOf = (one) => {
    if (one.aside && isOver(one, ...one.at)) return Infinity; // a label over its own point
    if (zoom <= 1 && !isInside(boxOf(one, home(one.at)), scatter)) return Infinity;
    return one.length + HIDES * occupied(one);
  };
  const candidates = labels.map(() => []); // of each label those that have been asked for
  /** Label i in place k, with its cost, the length of its line, and how far from its point it reaches, px. */
  const candidate = (i, k) => {
    if (candidates[i][k]) return candidates[i][k];
    const [label, offset] = [labels[i], offsets[k]];
    const length = Math.hypot(...offset);
    const reach = length + Math.hypot(label.width, label.height) / 2;
    const one = { ...label, at: at(label.row), offset, length, reach, aside: length > 0 };
    return (candidates[i][k] = { ...one, cost: costOf(one) });
  };
  /** What it costs among others, or a part of it that is too much. */
  const costAmong = (one, others, tooMuch = Infinity) => {
    let { cost } = one;
    for (const other of others) if (cost < tooMuch) cost += costOfTwo(one, other);
    return cost;
  };
  /** The best place of a label among others, or null. */
  const placeOf = (i, others) => {
    let [best, least] = [null, DEAREST];
    for (let k = 0; k < offsets.length && candidate(i, k).length < least; k++) {
      const one = candidate(i, k);
      const cost = costAmong(one, others, least);
      if (cost < least) [best, least] = [one, cost];
    }
    return best;
  };
  const places = labels.map(() => null);
  const others = (...without) => places.filter((other, k) => other && !without.includes(k));
  /** Two labels whose lines are in each other's way, placed anew, the one or the other first, if that costs less. */
  const placeTwo = (i, k) => {
    const [now, rest] = [[places[i], places[k]], others(i, k)];
    if (!costOfTwo(...now)) return now;
    const tries = [[i, k], [k, i]].map(([first, second]) => {
      const one = placeOf(first, rest);
      const other = one && placeOf(second, [...rest, one]);
      return first === i ? [one, other] : [other, one];
    });
    const total = ([one, other]) => costAmong(one, [...rest, other]) + costAmong(other, rest);
    const possible = tries.filter((two) => two.every(Boolean));
    return possible.reduce((best, two) => (total(two) < total(best) ? two : best), now);
  };
  for (let round = 0; round < ROUNDS; round++) {
    for (let i = 0; i < places.length; i++) places[i] = placeOf(i, others(i));
    for (const [i, one] of places.entries()) {
      for (let k = 0; one && k < i; k++) if (places[k]) [places[i], places[k]] = placeTwo(i, k);
    }
  }
  return places.filter(Boolean);
}

/** What it costs that two labels are where they are: nothing, or for their lines, or too much as they overlap. */
function costOfTwo(one, other) {
  if (Math.hypot(one.at[0] - other.at[0], one.at[1] - other.at[1]) > one.reach + other.reach + 2 * POINT) return 0;
  if (meet(one, other)) return Infinity;
  return CROSSES * cross(one, other) + COVERS * (lineIsOver(one, other) || lineIsOver(other, one));
}

/** The share of a label's cells that have a point. */
function occupiedCells({ x, y, count, middle }, unit) {
  const cells = new Set();
  const cellOf = (value) => Math.floor(value / OCCUPIED);
  for (let i = 0; i < count; i++) {
    cells.add(4096 * cellOf(unit * (x[i] - middle[0])) + cellOf(-unit * (y[i] - middle[1])));
  }
  return ({ at, offset, width, height }) => {
    let [found, all] = [0, 0];
    const [left, top] = [at[0] + offset[0] - width / 2, at[1] + offset[1] - height / 2];
    for (let u = cellOf(left); u <= cellOf(left + width); u++) {
      for (let v = cellOf(top); v <= cellOf(top + height); v++, all++) found += cells.has(4096 * u + v);
    }
    return found / all;
  };
}

/** Whether two labels overlap at any zoom, from that at which they are to twice that. */
function meet(a, b) {
  let [from, to] = [1, 2];
  for (let axis = 0; axis < 2; axis++) {
    const [moves, starts] = [a.at[axis] - b.at[axis], a.offset[axis] - b.offset[axis]];
    const reach = (axis ? a.height + b.height : a.width + b.width) / 2 + SMALL_GAP;
    if (Math.abs(moves) < 1e-9) {
      if (Math.abs(starts) >= reach) return false;
      continue;
    }
    const [one, other] = [(-reach - starts) / moves, (reach - starts) / moves];
    from = Math.max(from, Math.min(one, other));
    to = Math.min(to, Math.max(one, other));
  }
  return from <= to;
}

/** Whether a label is over a place. */
function isOver({ at, offset, width, height }, x, y) {
  return Math.abs(at[0] + offset[0] - x) < width / 2 && Math.abs(at[1] + offset[1] - y) < height / 2;
}

/** Whether the line of a label is over another label. */
function lineIsOver({ at, offset }, other) {
  for (let share = 0; share < 0.9; share += 0.2) {
    if (isOver(other, at[0] + share * offset[0], at[1] + share * offset[1])) return true;
  }
  return false;
}

/** Whether the lines of two labels cross, or one passes through the point of the other. */
function cross(a, b) {
  const around = Math.min(POINT, Math.hypot(a.at[0] - b.at[0], a.at[1] - b.at[1]) / 2); // px before a point
  return isCrossed(a, b, around) && isCrossed(b, a, around);
}

/** Whether the straight line on which a label's line lies is crossed by another's, which begins px before its point. */
function isCrossed(one, other, around) {
  const before = -around / Math.max(POINT, other.length);
  const [x, y, [u, v], [p, q]] = [other.at[0] - one.at[0], other.at[1] - one.at[1], one.offset, other.offset];
  const sideOf = (share) => u * (y + share * q) - v * (x + share * p);
  return sideOf(before) * sideOf(1) < 0;
}
