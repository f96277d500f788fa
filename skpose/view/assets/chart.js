// Coordinates in which paths between two poses are found: joints with three dofs turn freely.
//
// Three Euler angles reach every rotation, but badly: close rotations may have far angles. So a joint with three dofs
// has a rotation vector here, from the rotation half-way between those of the two poses; other angles are as they are.

const FARTHEST = 1.5 * Math.PI; // rotation vectors are at their best near zero, and useless at 2π

class Chart {
  /** Coordinates for paths between two poses; dofs that move the same joints of a branch at the root are neighbours. */
  constructor(skeleton, a, b) {
    const { joints } = skeleton;
    const branch = [];
    joints.forEach(({ parent }, j) => branch.push(parent < 0 ? j : branch[parent]));
    Object.assign(this, { skeleton, a, b, width: 0, branches: [], at: [], chains: [], references: [] });
    for (const root of new Set(branch)) {
      const low = this.width;
      joints.forEach(({ count }, j) => {
        if (branch[j] !== root) return;
        this.at[j] = this.width;
        this.width += count;
      });
      if (this.width > low) this.branches.push([low, this.width]);
    }
    joints.forEach(({ parent, count }, j) => {
      const own = Array.from({ length: count }, (_, i) => this.at[j] + i);
      this.chains.push([...(this.chains[parent] ?? []), ...own]); // coordinates that move the joint
      this.references.push(count === 3 ? this.middle(j) : null);
    });
  }

  /** The rotation of a joint in a pose, q or −q by the rule of `Skeleton.between`. */
  rotationIn(pose, j) {
    const joint = this.skeleton.joints[j];
    return canonical(this.skeleton.rotation(joint, pose), joint.signs);
  }

  /** The rotation of a joint half-way between the two poses. */
  middle(j) {
    const [p, q] = [this.a, this.b].map((pose) => this.rotationIn(pose, j));
    const sign = rotations.dot(p, q) < -TIE ? -1 : 1;
    const sum = p.map((value, i) => value + sign * q[i]);
    return rotations.scaled(sum, 1 / Math.hypot(...sum));
  }

  /** The coordinates of a pose; angles follow those of the first pose by differences wrapped to [−π, π] where asked. */
  coordinates(pose, wrap = false) {
    const found = new Float64Array(this.width);
    this.skeleton.joints.forEach(({ first, count }, j) => {
      if (count === 3) {
        const turn = rotations.product(rotations.inverse(this.references[j]), this.rotationIn(pose, j));
        return found.set(rotations.toVector(turn), this.at[j]);
      }
      for (let i = 0; i < count; i++) {
        const [from, to] = [this.a[first + i], pose[first + i]];
        found[this.at[j] + i] = wrap ? from + wrapped(wrapped(to) - wrapped(from)) : to;
      }
    });
    return found;
  }

  /** The pose of coordinates; of the numbers that are one rotation, those nearest to another pose's. */
  pose(coordinates, near) {
    const found = new Float64Array(this.skeleton.width);
    this.skeleton.joints.forEach((joint, j) => {
      const { isBall, axes, intrinsic, first, count } = joint;
      const before = Array.from(near.subarray(first, first + count));
      if (count < 3) {
        return found.set(before.map((value, i) => value + wrapped(coordinates[this.at[j] + i] - value)), first);
      }
      const q = this.rotation(joint, j, coordinates);
      found.set(isBall ? rotations.nearest(rotations.toVector(q), before)
        : rotations.toAngles(q, axes, intrinsic, before), first);
    });
    return found;
  }

  /** The rotation of a joint by its coordinates. */
  rotation(joint, j, coordinates) {
    const d = this.at[j];
    if (joint.count < 3) return this.skeleton.rotation(joint, coordinates, d);
    const turn = rotations.ofVector([coordinates[d], coordinates[d + 1], coordinates[d + 2]]);
    return rotations.product(this.references[j], turn);
  }

  /** Orientations of the joints, as `Skeleton.orientations`. */
  orientations(coordinates) {
    return this.skeleton.oriented((joint, j) => this.rotation(joint, j, coordinates));
  }

  positions(coordinates) {
    return this.skeleton.placed(this.orientations(coordinates));
  }

  /** The line on which joints with three dofs turn by slerp. */
  slerpLine(chords) {
    return divided([this.coordinates(this.a), this.coordinates(this.b, true)], chords);
  }

  /** The straight line of `Skeleton.between`, or null where a joint turns by too much for these coordinates. */
  straightLine(chords) {
    const line = straightLine(this.skeleton, this.a, this.b, chords).map((pose) => this.coordinates(pose));
    let near = true;
    this.skeleton.joints.forEach(({ count }, j) => {
      for (let i = 1; count === 3 && i < line.length; i++) {
        const vectors = [line[i - 1], line[i]].map((one) => Array.from(one.subarray(this.at[j], this.at[j] + 3)));
        const [before, vector] = vectors;
        const nearest = rotations.nearest(vector, before);
        line[i].set(nearest, this.at[j]);
        near &&= Math.hypot(...nearest) < FARTHEST;
      }
    });
    return near ? line : null;
  }

  /** The screw of each coordinate, six numbers, see `setScrew`. */
  screws(coordinates, orientations, positions) {
    const { skeleton } = this;
    const screws = new Float64Array(6 * this.width);
    skeleton.joints.forEach((joint, j) => {
      if (!joint.count) return;
      const { parent, frame, rest, count } = joint;
      const pivot = frame === j ? parent : j;
      const origin = pivot < 0 ? [0, 0, 0] : [0, 1, 2].map((i) => positions[3 * pivot + i]);
      if (count === 3) {
        const d = this.at[j];
        const jacobian = rotations.rightJacobian([coordinates[d], coordinates[d + 1], coordinates[d + 2]]);
        const after = quaternionAt(orientations, j);
        for (let i = 0; i < 3; i++) {
          const axis = rotations.apply(after, [jacobian[0][i], jacobian[1][i], jacobian[2][i]]);
          setScrew(screws, 6 * (d + i), axis, origin);
        }
        return;
      }
      let q = quaternionAt(orientations, parent);
      if (rest) q = rotations.product(q, rest);
      const steps = joint.axes.map((axis, i) => [axis, this.at[j] + i]);
      for (const [axis, d] of joint.intrinsic ? steps : steps.reverse()) {
        const direction = axis.length ? axis : [0, 1, 2].map((i) => (i === axis ? 1 : 0));
        setScrew(screws, 6 * d, rotations.apply(q, direction), origin);
        q = rotations.product(q, rotations.about(axis, coordinates[d]));
      }
    });
    return screws;
  }
}

/**
 * Write a screw: the axis a and the velocity b = o × a of a point at the root, with o on the axis. The coordinate moves
 * a point p, of its joint or of one below it, at the rate a × p + b.
 */
function setScrew(screws, at, [x, y, z], [u, v, w]) {
  screws[at] = x;
  screws[at + 1] = y;
  screws[at + 2] = z;
  screws[at + 3] = v * z - w * y;
  screws[at + 4] = w * x - u * z;
  screws[at + 5] = u * y - v * x;
}

/** Every step between coordinates divided into equal parts. */
function divided(nodes, parts) {
  const found = [nodes[0]];
  for (let i = 1; i < nodes.length; i++) {
    const [from, to] = [nodes[i - 1], nodes[i]];
    for (let k = 1; k < parts; k++) found.push(from.map((value, d) => value + (k / parts) * (to[d] - value)));
    found.push(to);
  }
  return found;
}

/** The sum of the chords between coordinates, and that of their squares. */
function chords(chart, nodes) {
  const positions = nodes.map((one) => chart.positions(one));
  let [length, energy] = [0, 0];
  for (let i = 1; i < nodes.length; i++) {
    const one = chord(chart.skeleton, positions[i - 1], positions[i]);
    length += one;
    energy += one * one;
  }
  return { length, energy };
}

/** The length of the curve through coordinates: joints with three dofs turn by slerp from one to the next. */
function curveLength(chart, nodes, parts) {
  const { skeleton } = chart;
  let length = 0;
  for (let i = 1; i < nodes.length; i++) {
    const [from, to] = [nodes[i - 1], nodes[i]];
    const turns = skeleton.joints.map((joint, j) => {
      if (joint.count < 3) return null;
      const [p, q] = [from, to].map((one) => chart.rotation(joint, j, one));
      return { from: p, vector: rotations.toVector(rotations.product(rotations.inverse(p), q)) };
    });
    let before = chart.positions(from);
    for (let k = 1; k <= parts; k++) {
      const part = from.map((value, d) => value + (k / parts) * (to[d] - value));
      const after = skeleton.placed(skeleton.oriented((joint, j) => {
        if (!turns[j]) return chart.rotation(joint, j, part);
        const turn = rotations.ofVector(turns[j].vector.map((value) => (k / parts) * value));
        return rotations.product(turns[j].from, turn);
      }));
      length += chord(skeleton, before, after);
      before = after;
    }
  }
  return length;
}
