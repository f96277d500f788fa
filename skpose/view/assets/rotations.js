// Rotations as unit quaternions [w, x, y, z], as rotation vectors, and as Euler angles; angles are rad.

const TIE = 1e-6; // a quaternion's number below which it may be zero but for rounding
const LOCKED = 1e-14; // cosine of the middle angle below which two Euler axes are one
const NO_ROTATION = 1e-12; // rotation below which there is none but for rounding, about no axis

/** The whole number that is nearest, of two the even one, as numpy's `rint`. */
function rint(value) {
  const below = Math.floor(value);
  if (value - below !== 0.5) return Math.round(value);
  return below % 2 ? below + 1 : below;
}

/** An angle wrapped to [−π, π]. */
const wrapped = (angle) => angle - 2 * Math.PI * rint(angle / (2 * Math.PI));

const rotations = {
  /** The rotation q, then p. */
  product: (p, q) => [
    p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
    p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
    p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
    p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
  ],

  inverse: ([w, x, y, z]) => [w, -x, -y, -z],

  dot: (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3],

  scaled: (q, factor) => q.map((value) => factor * value),

  /** A vector, rotated. */
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

  /** Of a rotation vector. */
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
    const sign = w >= -TIE ? 1 : -1;
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

  /** Part t of the shorter rotation from p to q; at half a turn their signs decide which. */
  slerp(p, q, t) {
    const [x, y, z] = rotations.toVector(rotations.product(rotations.inverse(p), q));
    return rotations.product(p, rotations.ofVector([t * x, t * y, t * z]));
  },

  /** 1 or −1, by which a quaternion is multiplied to be the same for q and −q: one rule for all. */
  sign: (q) => (q.find((value) => Math.abs(value) > TIE) < 0 ? -1 : 1),

  /** Rows of the right Jacobian: the rotation's rate about its own axes, by the rates of a rotation vector. */
  rightJacobian([x, y, z]) {
    const square = x * x + y * y + z * z;
    const [a, b] = jacobianCoefficients(square);
    const c = 1 - b * square;
    return [
      [c + b * x * x, b * x * y + a * z, b * x * z - a * y],
      [b * x * y - a * z, c + b * y * y, b * y * z + a * x],
      [b * x * z + a * y, b * y * z - a * x, c + b * z * z],
    ];
  },

  /** The three Euler angles of a rotation, by their axes in order, that are nearest to others. */
  toAngles([w, ...vector], axes, intrinsic, near) {
    const order = intrinsic ? [...axes].reverse() : axes;
    const parity = (order[1] - order[0] + 3) % 3 === 1 ? 1 : -1; // 1: right-handed
    const [x, y, z] = [vector[order[0]], vector[order[1]], parity * vector[order[2]]];
    const [a, b, c, d] = [w - y, x + z, y + w, z - x];
    const [halfSum, halfDifference] = [Math.atan2(b, a), Math.atan2(d, c)];
    const middle = 2 * Math.atan2(Math.hypot(c, d), Math.hypot(a, b)) - Math.PI / 2;
    let angles = [halfSum - halfDifference, middle, parity * (halfSum + halfDifference)];
    if (intrinsic) angles.reverse();
    if (Math.abs(Math.cos(middle)) < LOCKED) {
      // First and third axis are one line: only the sum of these angles, or their difference, is defined.
      const same = Math.sign(Math.sin(middle)) * parity;
      const excess = wrapped(near[0] - same * near[2] - (angles[0] - same * angles[2])) / 2;
      angles = [near[0] - excess, middle, near[2] + same * excess];
    }
    const [one, twin] = [angles, angles.map((angle, i) => (i === 1 ? -angle : angle) + Math.PI)].map((triple) =>
      triple.map((angle, i) => near[i] + wrapped(angle - near[i])));
    const far = (triple) => triple.reduce((sum, angle, i) => sum + (angle - near[i]) ** 2, 0);
    return far(twin) < far(one) ? twin : one;
  },

  /** The rotation vector of the same rotation that is nearest to another vector. */
  nearest(vector, near) {
    let size = Math.hypot(...vector);
    let axis = vector.map((value) => value / size);
    if (size < NO_ROTATION) {
      const far = Math.hypot(...near) || 1;
      axis = near.map((value) => value / far);
    }
    const turns = rint((axis[0] * near[0] + axis[1] * near[1] + axis[2] * near[2] - size) / (2 * Math.PI));
    return vector.map((value, i) => value + 2 * Math.PI * turns * axis[i]);
  },
};

/** (1 − cos θ)/θ² and (θ − sin θ)/θ³ at θ²: by their series where the closed forms lose digits. */
function jacobianCoefficients(square) {
  if (square < 1) return [factorialSeries(square, 2), factorialSeries(square, 3)];
  const angle = Math.sqrt(square);
  return [(1 - Math.cos(angle)) / square, (angle - Math.sin(angle)) / (square * angle)];
}

/** Their derivatives by θ, divided by θ. */
function jacobianSlopes(square) {
  if (square < 1) {
    return [2 * factorialSeries(square, 4) - factorialSeries(square, 3),
      3 * factorialSeries(square, 5) - factorialSeries(square, 4)];
  }
  const angle = Math.sqrt(square);
  const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
  return [(angle * sin - 2 * (1 - cos)) / square ** 2,
    (3 * sin - angle * cos - 2 * angle) / (square ** 2 * angle)];
}

/** Σ (−1)^k θ^2k / (2k + shift)! for θ² below one. */
function factorialSeries(square, shift) {
  let term = 1;
  for (let i = 2; i <= shift; i++) term /= i;
  let total = term;
  for (let k = 1; k < 12; k++) total += term *= -square / ((2 * k + shift) * (2 * k + shift - 1));
  return total;
}

/** m·∂Jl(v)eᵢ/∂vⱼ, row j, column i, where Jl(v)ᵀ m is given: how the axes of a rotation vector change with it. */
function secondDerivatives(v, given) {
  const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
  const square = v[0] ** 2 + v[1] ** 2 + v[2] ** 2;
  const [[a, b], [slopeA, slopeB]] = [jacobianCoefficients(square), jacobianSlopes(square)];
  const half = Math.sqrt(square) / 2;
  const c = square > 1e-3 ? (1 - half / Math.tan(half)) / square : 1 / 12 + square / 720 + square ** 2 / 30240;
  const [turned, back] = [cross(v, given), cross(v, cross(v, given))];
  const m = given.map((value, i) => value + turned[i] / 2 + c * back[i]); // Jl(v)⁻ᵀ of it
  const across = cross(v, m);
  const twice = cross(v, across);
  const along = v[0] * m[0] + v[1] * m[1] + v[2] * m[2];
  return [0, 1, 2].map((j) => {
    const row = [0, 1, 2].map((i) =>
      v[j] * (slopeB * twice[i] - slopeA * across[i]) + b * (m[j] * v[i] - 2 * m[i] * v[j]));
    const [next, last] = [(j + 1) % 3, (j + 2) % 3];
    row[j] += b * along;
    row[next] += a * m[last];
    row[last] -= a * m[next];
    return row;
  });
}
