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

  time(frame) {
    return (this.numbers ? this.numbers.at(frame, 0) : frame) / this.rate;
  }

  get duration() {
    return this.time(this.frames - 1);
  }

  /** The last frame that is not after a time. */
  frameAt(time) {
    return lastNotAfter(time, 0, this.frames - 1, (frame) => this.time(frame));
  }

  /** Whether the frame after this one was recorded right after it. */
  continues(frame) {
    if (frame < 0 || frame >= this.frames - 1) return false;
    return !this.numbers || this.numbers.at(frame + 1, 0) - this.numbers.at(frame, 0) < 1.5;
  }

  /** A time as a frame and a share of the time to the next one; where frames are missing the last one stays. */
  momentAt(time) {
    const frame = this.frameAt(time);
    const share = (time - this.time(frame)) * this.rate;
    return this.continues(frame) && share > 2e-4 ? Math.min(frame + share, frame + 1) : frame;
  }

  /** The sum of a value of frames that is there between them too: `value(frame)`. */
  between(moment, value) {
    const frame = Math.floor(moment);
    return moment === frame ? value(frame) : weighted(this.weights(moment), frame, value);
  }

  weights(moment) {
    const frame = Math.floor(moment);
    return cubicWeights(moment - frame, this.continues(frame - 1), this.continues(frame + 1));
  }

  isSeen(frame, joint) {
    return this.seen.at(frame, joint) > 0.5;
  }

  locals(moment) {
    const [frame, { joints, parents }] = [Math.floor(moment), this];
    const share = moment - frame;
    const all = this.weights(moment);
    const places = [];
    parents.forEach((parent, joint) => {
      const own = (at, axis) => joints.at(at, 3 * joint + axis);
      if (!share || (this.seen && !this.isSeen(frame + 1, joint))) {
        places.push([0, 1, 2].map((axis) => own(frame, axis)));
      } else if (this.seen) { // measured, each for itself
        places.push([0, 1, 2].map((axis) => (1 - share) * own(frame, axis) + share * own(frame + 1, axis)));
      } else {
        const vector = parent < 0 ? own : (at, axis) => own(at, axis) - joints.at(at, 3 * parent + axis);
        const [bone, [x, y, z]] = [boneBetween(vector, frame, share, all), places[parent] ?? [0, 0, 0]];
        places.push([x + bone[0], y + bone[1], z + bone[2]]);
      }
    });
    return places;
  }

  /** A function that moves a point from next to the root to where it is at a moment, see `point`. */
  placing(moment, place) {
    const [x0, y0, z0] = [0, 1, 2].map((axis) => this.between(moment, (frame) => this.root.at(frame, axis)));
    if (place === "world") return ([x, y, z]) => [x + x0, y + y0, z + z0];
    if (place !== "forward" || !this.headings) return ([x, y, z]) => [x, y + y0, z];
    const first = this.headings.at(Math.floor(moment), 0);
    const heading = first + this.between(moment, (frame) => nearZero(this.headings.at(frame, 0) - first));
    const [sin, cos] = [Math.sin(heading), Math.cos(heading)];
    return ([x, y, z]) => [cos * x - sin * z, y + y0, sin * x + cos * z];
  }

  /**
   * Position of a point at a moment, a frame or between two: 0 is the root, 1 the first joint. The root of keypoints is
   * their middle, and what is not seen has a position nevertheless. `place` is "world", as recorded, "spot", where the
   * root does not travel, or "forward", where it does not turn to the side either.
   */
  point(moment, index, place) {
    if (index && moment % 1) return this.points(moment, place)[index];
    const local = [0, 1, 2].map((axis) => (index ? this.joints.at(moment, 3 * (index - 1) + axis) : 0));
    return this.placing(moment, place)(local);
  }

  points(moment, place) {
    return [[0, 0, 0], ...this.locals(moment)].map(this.placing(moment, place));
  }

  /** Whether a point is drawn: of keypoints those that are seen, and not their middle. */
  shows(moment, index) {
    return !this.seen || (index > 0 && this.isSeen(Math.floor(moment), index - 1));
  }

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
  static async of({ path, distances, columns, largest }) {
    const unpacked = { path: await unpack(path), distances: await unpack(distances) };
    return Object.assign(new Pairs(), { ...unpacked, columns, largest });
  }

  /** Distance of a joint of motion i from its counterpart, m, at a pair or between two. */
  distance(pair, i, joint) {
    const [row, column] = [Math.floor(pair), this.columns[i][joint]];
    const next = Math.min(row + 1, this.distances.rows - 1);
    return (1 - pair + row) * this.distances.at(row, column) + (pair - row) * this.distances.at(next, column);
  }

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

  /** The moment of each motion at a tick or between two: a frame and a share of the time to the next one. */
  frames(tick) {
    if (!this.aligned) return this.clips.map((clip) => clip.momentAt(tick / this.rate));
    const [row, { path }] = [Math.floor(tick), this.pairs];
    return this.clips.map((clip, i) => {
      const frame = path.at(row, i);
      const goesOn = tick > row && path.at(row + 1, i) > frame && clip.continues(frame);
      return goesOn ? frame + tick - row : frame;
    });
  }
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
