// A skeleton's poses: where its joints are, and the straight line from a pose to another. Lengths are m, angles rad.

/** A skeleton, as written by `skeleton_data` of skpose/view/_explorer.py. A pose is a Float64Array of `width` columns. */
class Skeleton {
  constructor(data) {
    Object.assign(this, data);
    let first = 0; // column
    this.joints = data.dofs.map((dofs, j) => {
      const isBall = dofs === "rotvec";
      // The direction of the axis of a hinge; the numbers of the axes of other joints.
      const axes = isBall ? [] : data.axes[j] ? [data.axes[j]] : [...dofs.toLowerCase()].map((x) => "xyz".indexOf(x));
      const count = isBall ? 3 : axes.length;
      const joint = {
        parent: data.parents[j], offset: data.offsets[j], rest: data.rests[j], weight: data.weights[j],
        // The joint whose orientation the offset has; −1 is the root.
        frame: data.offsetFrame === "own" ? j : data.parents[j],
        isBall, axes, first, count, intrinsic: dofs === dofs.toUpperCase(),
      };
      first += count;
      return joint;
    });
    this.width = first;
  }

  rotation({ isBall, axes, first, intrinsic }, pose) {
    if (isBall) return rotations.ofVector([pose[first], pose[first + 1], pose[first + 2]]);
    let q = [1, 0, 0, 0];
    axes.forEach((axis, i) => {
      const one = rotations.about(axis, pose[first + i]);
      q = intrinsic ? rotations.product(q, one) : rotations.product(one, q);
    });
    return q;
  }

  /** The orientation of each joint's own axes in the world, four numbers [w, x, y, z] each. */
  orientations(pose) {
    const all = new Float64Array(4 * this.joints.length);
    this.joints.forEach((joint, j) => {
      let q = quaternionAt(all, joint.parent);
      if (joint.rest) q = rotations.product(q, joint.rest);
      if (joint.count) q = rotations.product(q, this.rotation(joint, pose));
      all.set(q, 4 * j);
    });
    return all;
  }

  /** The position of each joint relative to the root, three numbers each, without weights. */
  positions(pose) {
    const orientations = this.orientations(pose);
    const all = new Float64Array(3 * this.joints.length);
    this.joints.forEach(({ parent, offset, frame }, j) => {
      const along = rotations.apply(quaternionAt(orientations, frame), offset);
      for (let i = 0; i < 3; i++) all[3 * j + i] = along[i] + (parent < 0 ? 0 : all[3 * parent + i]);
    });
    return all;
  }

  /** The pose at part t of the straight line from a to b: angles by their wrapped difference, ball joints by slerp. */
  between(a, b, t) {
    const pose = Float64Array.from(a);
    for (const { isBall, first, count } of this.joints) {
      if (isBall) {
        const [p, q] = [a, b].map((one) => rotations.ofVector([...one.subarray(first, first + 3)]));
        pose.set(rotations.toVector(rotations.slerp(p, q, t)), first);
        continue;
      }
      // Wrapped before and after, as in `pose_distances`: half a turn has one direction for all equal angles.
      for (let d = first; d < first + count; d++) pose[d] += t * wrapped(wrapped(b[d]) - wrapped(a[d]));
    }
    return pose;
  }
}

/** The orientation of a joint's own axes, −1 for the root. */
const quaternionAt = (all, j) => (j < 0 ? [1, 0, 0, 0] : [all[4 * j], all[4 * j + 1], all[4 * j + 2], all[4 * j + 3]]);
