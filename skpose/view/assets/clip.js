// Motions in a page: which frame is when, where its joints are then, and which frames of two motions belong together.

class Clip {
  /** Unpack a motion or keypoints, see `motion_data` of skpose/view/_scene.py and `points_data` of _points.py. */
  static async of(motion) {
    const clip = Object.assign(new Clip(), motion);
    for (const name of ["joints", "root", "headings", "numbers", "seen"]) {
      if (motion[name]) clip[name] = await unpack(motion[name]);
    }
    clip.frames = clip.joints.rows;
    clip.ends = clip.names.map((_, joint) => joint).filter((joint) => !clip.parents.includes(joint));
    return clip;
  }

  /** Time of a frame after the first, s. */
  time(frame) {
    return (this.numbers ? this.numbers.at(frame, 0) : frame) / this.rate;
  }

  get duration() {
    return this.time(this.frames - 1);
  }

  /** The last frame that is not after a time. */
  frameAt(time) {
    let [first, last] = [0, this.frames - 1];
    while (first < last) {
      const middle = Math.ceil((first + last) / 2);
      if (this.time(middle) <= time + 1e-6) first = middle;
      else last = middle - 1;
    }
    return first;
  }

  /**
   * Position of a point in a frame: 0 is the root, 1 the first joint. The root of keypoints is their middle, and what
   * is not seen has a position nevertheless. `place` is "world", as recorded, "spot", where the root does not travel,
   * or "forward", where it does not turn to the side either.
   */
  point(frame, index, place) {
    const column = 3 * (index - 1);
    let [x, y, z] = index ? [0, 1, 2].map((axis) => this.joints.at(frame, column + axis)) : [0, 0, 0];
    y += this.root.at(frame, 1);
    if (place === "world") return [x + this.root.at(frame, 0), y, z + this.root.at(frame, 2)];
    if (place === "forward" && this.headings) {
      const heading = this.headings.at(frame, 0);
      const [sin, cos] = [Math.sin(heading), Math.cos(heading)];
      [x, z] = [cos * x - sin * z, sin * x + cos * z];
    }
    return [x, y, z];
  }

  /** Positions of the root and of all joints. */
  points(frame, place) {
    return Array.from({ length: this.names.length + 1 }, (_, index) => this.point(frame, index, place));
  }

  /** Whether a point is drawn: of keypoints those that are seen, and not their middle. */
  shows(frame, index) {
    return !this.seen || (index > 0 && this.seen.at(frame, index - 1) > 0.5);
  }

  /** Positions of what is drawn. */
  shown(frame, place) {
    return this.points(frame, place).filter((_, index) => this.shows(frame, index));
  }

  /** What a joint is called. */
  get kind() {
    return this.seen ? "point" : "joint";
  }

  /** The direction (azimuth) in which it goes, or faces where left and right are known, or null. */
  azimuth(place) {
    const [a, b] = [0, this.frames - 1].map((frame) => this.point(frame, 0, place));
    if (Math.hypot(b[0] - a[0], b[2] - a[2]) > 0.5 * this.size) return Math.atan2(b[0] - a[0], b[2] - a[2]);
    return facing(this.points(0, place), this.sides, 1e-3 * this.size);
  }
}

/** Frames of two motions that belong together, and how far their joints are apart there. */
class Pairs {
  static async of({ path, distances, columns }) {
    const pairs = Object.assign(new Pairs(), { path: await unpack(path), distances: await unpack(distances), columns });
    pairs.largest = 0;
    for (let row = 0; row < pairs.distances.rows; row++) {
      for (let column = 0; column < pairs.distances.columns; column++) {
        pairs.largest = Math.max(pairs.largest, pairs.distances.at(row, column));
      }
    }
    return pairs;
  }

  /** Distance of a joint of motion i from its counterpart, m. */
  distance(pair, i, joint) {
    return this.distances.at(pair, this.columns[i][joint]);
  }

  /** The same as a share of the largest distance. */
  share(pair, i, joint) {
    return this.largest && this.distance(pair, i, joint) / this.largest;
  }
}

/** The common time of motions: a tick is a pair of frames that belong together, or a frame of the fastest motion. */
class Clock {
  constructor(clips, pairs) {
    Object.assign(this, { clips, pairs, aligned: Boolean(pairs) });
    this.rate = Math.max(...clips.map((clip) => clip.rate));
    this.duration = Math.max(...clips.map((clip) => clip.duration));
  }

  get count() {
    return this.aligned ? this.pairs.path.rows : Math.round(this.duration * this.rate) + 1;
  }

  /** Duration of a tick, s: that of all pairs is the mean of the two motions'. */
  get seconds() {
    if (!this.aligned) return 1 / this.rate;
    const durations = this.clips.map((clip) => clip.duration);
    return mean(durations) / Math.max(this.count - 1, 1) || 1;
  }

  /** The frame of each motion at a tick. */
  frames(tick) {
    return this.clips.map((clip, i) => (this.aligned ? this.pairs.path.at(tick, i) : clip.frameAt(tick / this.rate)));
  }
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
