// Rotations as unit quaternions [w, x, y, z] and as rotation vectors; angles are rad.

/** The nearest whole number, of two the even one, like numpy's `rint`. */
function rint(value) {
  const below = Math.floor(value);
  if (value - below !== 0.5) return Math.round(value);
  return below % 2 ? below + 1 : below;
}

const wrapped = (angle) => angle - 2 * Math.PI * rint(angle / (2 * Math.PI));

const rotations = {
  product: (p, q) => [
    p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
    p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
    p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
    p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
  ],

  inverse: ([w, x, y, z]) => [w, -x, -y, -z],

  apply(q, v) {
    const r = 2 * (q[2] * v[2] - q[3] * v[1]);
    const s = 2 * (q[3] * v[0] - q[1] * v[2]);
    const t = 2 * (q[1] * v[1] - q[2] * v[0]);
    return [
      v[0] + q[0] * r + q[2] * t - q[3] * s,
      v[1] + q[0] * s + q[3] * r - q[1] * t,
      v[2] + q[0] * t + q[1] * s - q[2] * r,
    ];
  },

  ofVector([x, y, z]) {
    const angle = Math.sqrt(x * x + y * y + z * z);
    const share = angle > 1e-15 ? Math.sin(angle / 2) / angle : 0.5;
    return [Math.cos(angle / 2), share * x, share * y, share * z];
  },

  /** About an axis, 0, 1 or 2, or about a direction of length one. */
  about(axis, angle) {
    if (axis.length) return rotations.ofVector(axis.map((x) => x * angle));
    const q = [Math.cos(angle / 2), 0, 0, 0];
    q[axis + 1] = Math.sin(angle / 2);
    return q;
  },

  /** The rotation vector, no longer than π. */
  toVector([w, x, y, z]) {
    const sine = Math.hypot(x, y, z);
    const sign = w >= 0 ? 1 : -1;
    const share = sine > 1e-300 ? (2 * sign * Math.atan2(sine, sign * w)) / sine : 2;
    return [share * x, share * y, share * z];
  },

  /** The angle between two rotations, 0 to π; exact for small ones too. */
  angleBetween(p, q) {
    let [minus, plus] = [0, 0];
    for (let i = 0; i < 4; i++) {
      minus += (q[i] - p[i]) ** 2;
      plus += (q[i] + p[i]) ** 2;
    }
    return 4 * Math.asin(Math.sqrt(Math.min(minus, plus)) / 2);
  },

  /** Part t of the shorter rotation from p to q. */
  slerp(p, q, t) {
    const [x, y, z] = rotations.toVector(rotations.product(rotations.inverse(p), q));
    return rotations.product(p, rotations.ofVector([t * x, t * y, t * z]));
  },
};
