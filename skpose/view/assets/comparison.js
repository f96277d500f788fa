// Two poses: the straight line and the shortest path between them as figures, and their distances by all metrics.

const LINE_PARTS = 64; // parts of the straight line by which its length is measured

/** A path of poses at constant speed of all joints together: `at(share)` is the pose at a share of its length. */
class Travel {
  constructor(skeleton, poses) {
    Object.assign(this, { skeleton, poses, travelled: [0] });
    const places = poses.map((pose) => skeleton.positions(pose));
    for (let i = 1; i < poses.length; i++) {
      this.travelled.push(this.travelled[i - 1] + chord(skeleton, places[i - 1], places[i]));
    }
  }

  at(share) {
    const { poses, travelled, skeleton } = this;
    const [last, length] = [poses.length - 1, travelled.at(-1)];
    if (!length) return poses[Math.round(share * last)];
    let i = travelled.findIndex((far) => far >= share * length);
    i = Math.max(1, i < 0 ? last : i);
    const step = travelled[i] - travelled[i - 1];
    return skeleton.between(poses[i - 1], poses[i], step ? (share * length - travelled[i - 1]) / step : 0);
  }
}

/** What is known of two poses; `changed` is called when the shortest path has been found. */
class Comparison {
  geodesic = null;
  failure = "";
  stopped = false;

  constructor(poses, first, second, changed) {
    const { skeleton, data } = poses;
    const [a, b] = [poses.pose(first), poses.pose(second)];
    Object.assign(this, { first, second });
    this.distances = distances(skeleton, a, b, data.steps);
    this.metrics = data.metrics.filter(({ name }) => name in this.distances || name === "geodesic");
    const line = Array.from({ length: LINE_PARTS + 1 }, (_, i) => skeleton.between(a, b, i / LINE_PARTS));
    this.paths = { line: new Travel(skeleton, line), shortest: null };
    this.done = this.search(skeleton, a, b, data.steps, changed);
  }

  async search(skeleton, a, b, chords, changed) {
    try {
      this.geodesic = await geodesic(skeleton, a, b, { chords, isStopped: () => this.stopped });
      this.distances.geodesic = this.geodesic.length;
      this.paths.shortest = new Travel(skeleton, this.geodesic.poses);
    } catch (error) {
      this.failure = String(error.message);
    }
    if (!this.stopped) changed();
  }

  /** End the search and report nothing more: other poses have been chosen. */
  stop() {
    this.stopped = true;
  }

  /** The name of a path, with its length. */
  label(name) {
    const metric = name === "line" ? "spatial" : "geodesic";
    const words = name === "line" ? "straight line" : "shortest path";
    return metric in this.distances ? `${words}, ${this.distance(metric)}` : words;
  }

  /** A distance with its unit; a geodesic's with fewer digits, as searches from rounded poses may end elsewhere. */
  distance(metric) {
    const { unit } = this.metrics.find(({ name }) => name === metric);
    return `${Number(this.distances[metric].toPrecision(metric === "geodesic" ? 3 : 4))} ${unit}`;
  }

  /** The rows of the table of distances: metric, value, note. */
  rows() {
    return this.metrics.map(({ name }) => {
      if (name in this.distances) {
        const converged = name !== "geodesic" || this.geodesic.converged;
        return [name, this.distance(name), converged ? "" : "not converged"];
      }
      return [name, this.failure ? "–" : "…", this.failure || "is computed"];
    });
  }
}
