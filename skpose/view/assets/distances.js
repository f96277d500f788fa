// Distances between two poses, as `pose_distances` defines them.

/** The distance between two results of `Skeleton.positions`, each joint by its weight, m. */
function chord(skeleton, p, q) {
  let square = 0;
  skeleton.joints.forEach(({ weight }, j) => {
    for (let i = 3 * j; i < 3 * j + 3; i++) square += weight * (q[i] - p[i]) ** 2;
  });
  return Math.sqrt(square);
}

/** The root of the sum of squared angles between the orientations of the bones, by their lengths, m. */
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

/** The distances without a search, "spatial" as the sum of so many chords: `angle` in rad, the others in m. */
function distances(skeleton, a, b, nSteps = 10) {
  const line = Array.from({ length: nSteps + 1 }, (_, i) => skeleton.positions(skeleton.between(a, b, i / nSteps)));
  return {
    angle: Math.hypot(...a.map((value, d) => b[d] - value)),
    position: chord(skeleton, skeleton.positions(a), skeleton.positions(b)),
    rotation: rotationDistance(skeleton, a, b),
    spatial: line.slice(1).reduce((sum, points, i) => sum + chord(skeleton, line[i], points), 0),
  };
}
