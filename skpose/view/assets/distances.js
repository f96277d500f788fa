// Distances between two poses, as `pose_distances` defines them; the geodesic has a file of its own.

/** The distance between two results of `Skeleton.positions`, each joint by its weight, m. */
function chord(skeleton, p, q) {
  let square = 0;
  skeleton.joints.forEach(({ weight }, j) => {
    for (let i = 3 * j; i < 3 * j + 3; i++) square += weight * (q[i] - p[i]) ** 2;
  });
  return Math.sqrt(square);
}

/** The sum of the chords between poses, m. */
function lengthOf(skeleton, poses) {
  const positions = poses.map((pose) => skeleton.positions(pose));
  let length = 0;
  for (let i = 1; i < positions.length; i++) length += chord(skeleton, positions[i - 1], positions[i]);
  return length;
}

/** Poses on the straight line from a to b, at equal steps, the ends among them. */
const straightLine = (skeleton, a, b, nSteps) =>
  Array.from({ length: nSteps + 1 }, (_, i) => skeleton.between(a, b, i / nSteps));

/** `rotation`: the root of the sum of squared angles between the orientations of the bones, by their lengths, m. */
function rotationDistance(skeleton, a, b) {
  const [p, q] = [a, b].map((pose) => skeleton.orientations(pose));
  let square = 0;
  for (const { frame, offset, weight } of skeleton.joints) {
    if (frame < 0) continue; // fixed to the root
    const [from, to] = [p, q].map((all) => all.subarray(4 * frame, 4 * frame + 4));
    square += weight * (offset[0] ** 2 + offset[1] ** 2 + offset[2] ** 2) * rotations.angleBetween(from, to) ** 2;
  }
  return Math.sqrt(square);
}

/** The four distances that need no search, "spatial" by so many chords: `angle` in rad, the others in m. */
function distances(skeleton, a, b, nSteps = 10) {
  const ends = [a, b].map((pose) => skeleton.positions(pose));
  let square = 0;
  for (let d = 0; d < skeleton.width; d++) square += (b[d] - a[d]) ** 2;
  return {
    angle: Math.sqrt(square),
    position: chord(skeleton, ...ends),
    rotation: rotationDistance(skeleton, a, b),
    spatial: lengthOf(skeleton, straightLine(skeleton, a, b, nSteps)),
  };
}
