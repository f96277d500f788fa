// What is between two recorded frames: cubic curves through the frames around (Catmull-Rom), smooth in time.

/**
 * Weights of the frame before, both frames and the one after, at a share of the time between the two; `before` and
 * `after` are whether these were recorded, or else the speed is that between the two.
 */
function cubicWeights(share, before, after) {
  const rest = 1 - share;
  const [first, second] = [share * rest * rest, -share * share * rest]; // of the speeds at both
  return [
    before ? -first / 2 : 0,
    (1 + 2 * share) * rest * rest - (before ? 0 : first) - (after ? second / 2 : second),
    (3 - 2 * share) * share * share + (before ? first / 2 : first) + (after ? 0 : second),
    after ? second / 2 : 0,
  ];
}

function weighted(weights, frame, value) {
  return weights.reduce((sum, weight, i) => (weight ? sum + weight * value(frame - 1 + i) : sum), 0);
}

/**
 * A bone between two frames, from its vectors in all frames. Its length is that of the recorded ones, between which a
 * curve through vectors is shorter; a bone that turns by half a turn from one frame to the next stays as it was.
 */
function boneBetween(vector, frame, share, weights) {
  const bone = [0, 1, 2].map((axis) => weighted(weights, frame, (at) => vector(at, axis)));
  const lengthAt = (at) => Math.hypot(...[0, 1, 2].map((axis) => vector(at, axis)));
  const [length, found] = [(1 - share) * lengthAt(frame) + share * lengthAt(frame + 1), Math.hypot(...bone)];
  if (found > 0.1 * length) return bone.map((value) => (value * length) / found);
  return [0, 1, 2].map((axis) => vector(frame, axis));
}

const nearZero = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
