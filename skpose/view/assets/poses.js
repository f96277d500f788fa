// The poses of an explorer: their numbers, times, motions and groups, and where their joints are.

class Poses {
  static async of(data) {
    const [numbers, times] = [await unpack(data.poses), await unpack(data.times)];
    const poses = Object.assign(new Poses(), { data, count: numbers.rows, width: numbers.columns });
    poses.skeleton = new Skeleton(data.skeleton);
    poses.numbers = new Float64Array(numbers.rows * numbers.columns);
    poses.times = new Float64Array(numbers.rows);
    poses.motionOf = new Uint32Array(numbers.rows);
    for (let row = 0; row < numbers.rows; row++) {
      for (let k = 0; k < numbers.columns; k++) poses.numbers[row * numbers.columns + k] = numbers.at(row, k);
      poses.times[row] = times.at(row, 0);
    }
    let end = 0;
    poses.ranges = data.counts.map((count, motion) => {
      poses.motionOf.fill(motion, end, end + count);
      return { first: end, end: (end += count) };
    });
    return poses;
  }

  pose(row) {
    return this.numbers.subarray(row * this.width, (row + 1) * this.width);
  }

  range(row) {
    return this.ranges[this.motionOf[row]];
  }

  label(row) {
    return this.data.labels[this.motionOf[row]];
  }

  time(row) {
    return this.times[row] - this.times[this.range(row).first];
  }

  /** How long a motion plays, s: the last pose is as long as the others. */
  duration({ first, end }) {
    const last = this.time(end - 1);
    return last + last / Math.max(end - first - 1, 1);
  }

  rowAt({ first, end }, time) {
    return lastNotAfter(time, first, end - 1, (row) => this.times[row] - this.times[first]);
  }

  /** Positions of root and joints of a pose, with y up, m. */
  points(pose) {
    const flat = this.skeleton.positions(pose);
    const { order, signs } = this.data.up;
    const points = [[0, 0, 0]];
    for (let joint = 0; joint < flat.length; joint += 3) {
      points.push(order.map((axis, i) => signs[i] * flat[joint + axis]));
    }
    return points;
  }

  /**
   * The groups of a choice of colours: their names, and the index of each pose's group. Of "time" there are no names;
   * `of` is then the share of the longest duration.
   */
  groups(by) {
    if (by === "time") {
      const of = Float64Array.from(this.times, (_, row) => this.time(row));
      const longest = of.reduce((most, time) => Math.max(most, time), 0);
      return { names: null, of: longest ? of.map((time) => time / longest) : of, longest };
    }
    const known = this.data.groups.find((groups) => groups.by === by);
    if (!known) return { names: this.data.labels, of: this.motionOf };
    return { names: known.names, of: Uint32Array.from(this.motionOf, (motion) => known.of[motion]) };
  }
}

/** Which poses are chosen, as how many of each motion, the most first. */
function countMotions(poses, chosen) {
  const counts = new Map();
  for (const row of chosen) {
    const motion = poses.motionOf[row];
    const one = counts.get(motion) ?? counts.set(motion, { motion, count: 0, first: row }).get(motion);
    one.count++;
  }
  return [...counts.values()].sort((a, b) => b.count - a.count || a.motion - b.motion);
}
