// The figure of an explorer: the pose under the pointer, that of the time, or one on the line between two poses.

const SOME = 48; // poses by which the camera is placed

class PoseView {
  camera = new Camera();
  centre = [0, 0, 0];
  points = []; // as drawn last

  constructor(canvas, poses) {
    Object.assign(this, { canvas, poses, context: canvas.getContext("2d"), size: poses.data.size });
    const rows = Array.from({ length: SOME }, (_, i) => Math.round((i * (poses.count - 1)) / (SOME - 1)));
    const { shape } = poses.data.skeleton;
    this.around = [...new Set(rows)].flatMap((row) => reachOf(shape, poses.points(poses.pose(row)), () => true));
    this.centre = centreOfBox(this.around);
  }

  get area() {
    return { x: 0, y: 0, width: this.canvas.clientWidth, height: this.canvas.clientHeight };
  }

  /** Place the camera such that every pose is seen; with `turn` from the side of the front. */
  fit(turn) {
    const { camera, poses, centre, around, size, area } = this;
    if (turn) {
      const front = facing(poses.points(poses.pose(0)), poses.data.skeleton.sides, 1e-3 * size);
      Object.assign(camera, { azimuth: (front ?? 0) + 0.5, elevation: 0.15, zoom: 1, shift: [0, 0] });
    }
    const points = around.map((point) => point.map((value, axis) => value - centre[axis]));
    camera.distance = Math.max(camera.distanceTo(points, area), 0.5 * size);
  }

  shown({ hover, comparison, share, current }) {
    if (hover < 0 && comparison) return comparison.at(share);
    return this.poses.pose(hover >= 0 ? hover : current);
  }

  draw(state) {
    sharpen(this.canvas, this.context);
    this.paint(this.context, state);
  }

  /** Draw into any canvas, whose unit is a px of that of the page. */
  paint(context, state) {
    const { poses, size, area } = this;
    const { shape, sides } = poses.data.skeleton;
    const view = this.camera.view(area, this.centre);
    this.points = poses.points(this.shown(state));
    const colourOf = (joint) => colours[sides[joint] || "middle"];
    context.save();
    context.beginPath();
    context.rect(0, 0, area.width, area.height);
    context.clip();
    drawFigure(context, view, this.points, shape, { size, colourOf });
    drawAxes(context, view, poses.data.up.names);
    if (sides.some(Boolean)) drawSides(context, area.width - 4, 16);
    context.restore();
  }
}
