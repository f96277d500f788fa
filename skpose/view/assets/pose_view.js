// The figures of an explorer: one pose, or two paths between two poses side by side.

const SOME = 48; // poses by which the camera is placed

class PoseView {
  camera = new Camera();
  centre = [0, 0, 0];
  figures = []; // as drawn last
  comparison = null; // whose two figures are shown

  constructor(canvas, poses) {
    Object.assign(this, { canvas, poses, context: canvas.getContext("2d"), size: poses.data.size });
    const rows = Array.from({ length: SOME }, (_, i) => Math.round((i * (poses.count - 1)) / (SOME - 1)));
    this.some = [...new Set(rows)].map((row) => poses.pose(row));
  }

  /** Rectangles of one figure or of two. */
  areas(count) {
    const [width, height] = [this.canvas.clientWidth / count, this.canvas.clientHeight];
    return Array.from({ length: count }, (_, i) => ({ x: i * width, y: 0, width, height }));
  }

  /** Place the camera such that every pose is seen, or both paths; with `turn` from the side of the front. */
  fit(turn) {
    const { camera, poses, comparison } = this;
    const { shape } = poses.data.skeleton;
    const some = comparison?.paths.line.poses ?? this.some;
    const around = some.flatMap((pose) => reachOf(shape, poses.points(pose), () => true));
    this.centre = [0, 1, 2].map((axis) => {
      const values = around.map((point) => point[axis]);
      return (Math.min(...values) + Math.max(...values)) / 2;
    });
    if (turn) {
      const front = facing(poses.points(poses.pose(0)), poses.data.skeleton.sides, 1e-3 * this.size);
      Object.assign(camera, { azimuth: (front ?? 0) + 0.5, elevation: 0.15, zoom: 1, shift: [0, 0] });
    }
    const points = around.map((point) => point.map((value, axis) => value - this.centre[axis]));
    camera.distance = Math.max(camera.distanceTo(points, this.areas(comparison ? 2 : 1)[0]), 0.5 * this.size);
  }

  /** The poses that are shown: that under the pointer, two on their paths, or that of the time. */
  shown({ hover, comparison, share, current }) {
    const { poses } = this;
    if (hover >= 0 || !comparison) return [poses.pose(hover >= 0 ? hover : current)];
    const { shortest, line } = comparison.paths;
    return [shortest ? shortest.at(share) : poses.pose(comparison.first), line.at(share)];
  }

  draw(state) {
    sharpen(this.canvas, this.context);
    this.figures = this.paint(this.context, state);
  }

  /** Draw into any canvas, whose unit is a px of that of the page; return the figures. */
  paint(context, state) {
    const { poses, size } = this;
    const shown = this.shown(state);
    const comparison = shown.length > 1 ? state.comparison : null;
    if (comparison !== this.comparison) {
      this.comparison = comparison;
      this.fit(false);
    }
    const { shape, sides } = poses.data.skeleton;
    return this.areas(shown.length).map((area, i) => {
      const view = this.camera.view(area, this.centre);
      const points = poses.points(shown[i]);
      const colourOf = (joint) => colours[sides[joint] || "middle"];
      context.save();
      context.beginPath();
      context.rect(area.x, area.y, area.width, area.height);
      context.clip();
      drawFigure(context, view, points, shape, { size, colourOf });
      if (!i) drawAxes(context, view, poses.data.up.names);
      if (i === shown.length - 1 && sides.some(Boolean)) drawSides(context, area.x + area.width - 4, area.y + 16);
      context.restore();
      return { area, points };
    });
  }
}
