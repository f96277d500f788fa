// The plane of an explorer with the pose, its name and the colours next to it, as one picture for files.

const [EDGE, ROW] = [16, 24]; // px

class Sheet {
  /** `drawPlane(context, state)` draws what is over the points; `keyOf(state)` is a name and a list of groups. */
  constructor(scatter, view, drawPlane, keyOf) {
    Object.assign(this, { scatter, view, drawPlane, keyOf });
  }

  get isTall() {
    const [plane, figure] = [this.scatter, this.view].map(({ canvas }) => canvas.getBoundingClientRect());
    return figure.top >= plane.bottom;
  }

  get canvas() {
    const { scatter: { width, height }, view: { canvas } } = this;
    if (this.isTall) return { clientWidth: width, clientHeight: height + canvas.clientHeight + 2 * ROW };
    return { clientWidth: width + canvas.clientWidth + 2 * EDGE, clientHeight: height };
  }

  paint(context, state) {
    const { scatter, view, isTall } = this;
    const { width, height } = scatter;
    scatter.paint(context);
    context.save();
    context.beginPath();
    context.rect(0, 0, width, height);
    context.clip();
    this.drawPlane(context, state);
    context.restore();
    context.save();
    context.translate(...(isTall ? [(width - view.canvas.clientWidth) / 2, height] : [width + EDGE, 0]));
    view.paint(context, state);
    this.drawKey(context, state, view.canvas.clientHeight + ROW, isTall);
    context.restore();
  }

  drawKey(context, state, top, isTall) {
    const { name, groups } = this.keyOf(state);
    const most = this.view.canvas.clientWidth;
    Object.assign(context, { font: "15px system-ui, sans-serif", textAlign: "left", textBaseline: "middle" });
    context.fillStyle = colours.ink;
    context.fillText(name, 0, top, most);
    if (isTall) return;
    const room = Math.max(0, Math.floor((this.scatter.height - top - 1.5 * ROW) / ROW));
    const shown = groups.length > room ? groups.slice(0, Math.max(0, room - 1)) : groups;
    const others = groups.length - shown.length;
    const lines = others && room ? [...shown, { words: `and ${others} more` }] : shown;
    lines.forEach(({ words, colour, form }, i) => {
      const y = top + (i + 1.5) * ROW;
      context.fillStyle = colour ?? colours.quiet;
      if (colour) fillForm(context, form, 6, y, 5.5);
      context.fillStyle = colour ? colours.ink : colours.quiet;
      context.fillText(words, 20, y, most - 20);
    });
  }
}
