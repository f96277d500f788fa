// Two poses: the straight line between them, and their distances under the metrics that need no search.

class Comparison {
  constructor(poses, first, second) {
    const { skeleton, data } = poses;
    const [a, b] = [poses.pose(first), poses.pose(second)];
    const values = distances(skeleton, a, b, data.steps);
    /** The pose at a share of the straight line. */
    const at = (share) => skeleton.between(a, b, share);
    const words = ({ name, unit }) => `${Number(values[name].toPrecision(4))} ${unit}`;
    const rows = data.metrics.map((metric) => [metric.name, words(metric)]); // of the table
    Object.assign(this, { first, second, distances: values, at, rows });
    this.label = `straight line, ${words(data.metrics.find(({ name }) => name === "spatial"))}`;
  }
}
