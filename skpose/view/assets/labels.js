// Where the labels of groups are: near their points, where few other points are, and none over another.

const RADII = [0, 50, 75, 100, 130, 165, 205, 250, 300, 360]; // px from the point to the middle of its label
const LEASH = 0.4; // of the canvas' shorter side
const ROUNDS = 3; // in which each is placed among all others
const DIRECTIONS = 16;
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
  const { middle, x, y } = scatter;
  const placeOf = (row) => [unit * (x[row] - middle[0]), -unit * (y[row] - middle[1])];
  const occupied = occupiedCells(Array.from(x, (_, row) => placeOf(row)));
  const most = LEASH * Math.min(scatter.width, scatter.height);
  const offsets = RADII.filter((radius) => radius <= most).flatMap((radius) =>
    (radius ? circle(DIRECTIONS) : [[0, 0]]).map((direction) => direction.map((share) => radius * share)));
  const candidates = labels.map((label) => {
    const at = placeOf(label.row);
    const home = [scatter.width / 2 + at[0], scatter.height / 2 + at[1]]; // where all is seen
    return offsets.map((offset) => ({ ...label, at, offset, aside: Math.hypot(...offset) > 0 }))
      .filter((one) => !(one.aside && isOver(one, one.at)) && (zoom > 1 || isInside(boxOf(one, home), scatter)))
      .map((one) => ({ ...one, cost: Math.hypot(...one.offset) + HIDES * occupied(one) }));
  });
  const costAmong = (one, others) => others.reduce((sum, other) => sum + costOfTwo(one, other), one.cost);
  const best = (i, others) => {
    let [found, least] = [null, DEAREST];
    for (const one of candidates[i]) {
      const cost = one.cost < least ? costAmong(one, others) : Infinity;
      if (cost < least) [found, least] = [one, cost];
    }
    return found;
  };
  const places = labels.map(() => null);
  const others = (...without) => places.filter((one, i) => one && !without.includes(i));
  /** Place two labels whose lines are in each other's way anew, the one or the other first, if that costs less. */
  const placeBoth = (i, k) => {
    const rest = others(i, k);
    const total = (two) => costAmong(two[0], [...rest, two[1]]) + costAmong(two[1], rest);
    for (const [first, second] of [[i, k], [k, i]]) {
      const one = best(first, rest);
      const other = one && best(second, [...rest, one]);
      if (other && total([one, other]) < total([places[first], places[second]])) {
        [places[first], places[second]] = [one, other];
      }
    }
  };
  for (let round = 0; round < ROUNDS; round++) {
    for (let i = 0; i < places.length; i++) places[i] = best(i, others(i));
    for (let i = 0; i < places.length; i++) {
      for (let k = 0; k < i; k++) {
        if (places[i] && places[k] && costOfTwo(places[i], places[k])) placeBoth(i, k);
      }
    }
  }
  return places.filter(Boolean);
}

/** What it costs that two labels are where they are: nothing, or for their lines, or too much as they overlap. */
function costOfTwo(one, other) {
  if (meet(one, other)) return Infinity;
  return CROSSES * cross(one, other) + COVERS * (lineIsOver(one, other) || lineIsOver(other, one));
}

/** The share of a label's cells that have a point. */
function occupiedCells(places) {
  const cellOf = (value) => Math.floor(value / OCCUPIED);
  const cells = new Set(places.map(([x, y]) => 4096 * cellOf(x) + cellOf(y)));
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

const isOver = ({ at, offset, width, height }, [x, y]) =>
  Math.abs(at[0] + offset[0] - x) < width / 2 && Math.abs(at[1] + offset[1] - y) < height / 2;

const lineIsOver = ({ at, offset }, other) =>
  [0, 0.2, 0.4, 0.6, 0.8].some((share) => isOver(other, at.map((value, axis) => value + share * offset[axis])));

function cross(a, b) {
  const isBetween = (one, [u, v], { at: [x, y], offset: [p, q] }) => {
    const sideOf = (share) => u * (y + share * q - one[1]) - v * (x + share * p - one[0]);
    return sideOf(0) * sideOf(1) < 0;
  };
  return isBetween(a.at, a.offset, b) && isBetween(b.at, b.offset, a);
}
