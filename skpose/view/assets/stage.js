// The picture of the player: one view for each motion, or one for all, and what is in it.

const [TRAIL, GHOST] = [1, 0.35]; // s: how long trails are, and from one ghost to the next
const LEAST_HEIGHT = 0.02; // of the eye above the ground, sizes
const [MARGIN, LINE] = [14, 20]; // of texts, px

class Stage {
  camera = new Camera();
  hover = null; // motion and index of the point under the pointer
  views = []; // as drawn last
  columns = 1; // of views
  centre = [0, 0, 0]; // of what is to be seen, in space, or relative to the target that is followed

  constructor(canvas, clips, clock, options) {
    Object.assign(this, { canvas, clips, clock, options, context: canvas.getContext("2d") });
    this.size = Math.max(...clips.map((clip) => clip.size));
  }

  get overlaid() {
    return this.clips.length > 1 && this.options.layout === "overlay";
  }

  get follows() {
    return this.options.follow && this.options.place === "world";
  }

  get compares() {
    return this.clock.aligned && this.options.differences;
  }

  /** Whether left and right have their colours in a view of motions. */
  showsSides(members) {
    return !this.overlaid && !this.compares && this.clips[members[0]].sides.some(Boolean);
  }

  get members() {
    const all = this.clips.map((_, i) => i);
    return this.overlaid ? [all] : all.map((i) => [i]);
  }

  areas(columns) {
    const n = this.members.length;
    const [width, height] = [this.canvas.clientWidth / columns, this.canvas.clientHeight / Math.ceil(n / columns)];
    return Array.from({ length: n }, (_, i) => ({
      x: (i % columns) * width, y: Math.floor(i / columns) * height, width, height,
    }));
  }

  /** A function that moves a point aside where all motions are in one picture: across where the first one goes. */
  aside(i) {
    const far = this.overlaid ? (i - (this.clips.length - 1) / 2) * Number(this.options.apart) : 0;
    this.front ??= this.clips.map((clip) => clip.azimuth("world")).find((angle) => angle !== null) ?? 0;
    return ([x, y, z]) => [x + far * Math.cos(this.front), y, z - far * Math.sin(this.front)];
  }

  /** What the camera looks at: a fixed point, or one that goes with the roots. */
  target(members, frames) {
    if (!this.follows) return this.centre;
    const roots = members.map((i) => this.clips[i].point(frames[i], 0, "world"));
    return [mean(roots.map(([x]) => x)), this.centre[1], mean(roots.map(([, , z]) => z))];
  }

  /**
   * Place the camera such that all is seen, at equal distance in all views, which are as many in a row as makes the
   * figures largest; with `turn` from the side of the front.
   */
  fit(turn) {
    const { clips, clock, camera, options: { place } } = this;
    const some = new Set(Array.from({ length: 60 }, (_, i) => Math.round((i * (clock.count - 1)) / 59)));
    const points = [];
    this.centre = [0, 0, 0];
    for (const members of this.members) {
      for (const tick of some) {
        const frames = clock.frames(tick);
        const target = this.target(members, frames);
        const seen = members.flatMap((i) => reachOf(clips[i].shape, ...this.figure(i, frames[i])));
        points.push(...seen.map((point) => point.map((value, axis) => value - target[axis])));
      }
    }
    if (!points.length) points.push([0, 0, 0]); // of keypoints that are seen in few frames
    this.centre = centreOfBox(points).map((value, axis) => (this.follows && axis !== 1 ? 0 : value));
    if (turn) {
      const front = clips.map((clip) => clip.azimuth(place)).find((angle) => angle !== null);
      const azimuth = front === undefined ? 0.35 : front - 0.9;
      Object.assign(camera, { azimuth, elevation: 0.2, zoom: 1, shift: [0, 0] });
    }
    const around = points.map((point) => point.map((value, axis) => value - this.centre[axis]));
    let largest = 0;
    for (let columns = 1; columns <= this.members.length; columns++) {
      const [area] = this.areas(columns);
      const distance = Math.max(camera.distanceTo(around, area, LINE), 0.5 * this.size);
      const scale = Math.min(area.width, area.height) / distance;
      if (scale <= largest) continue;
      largest = scale;
      Object.assign(this, { columns });
      Object.assign(camera, { distance });
    }
  }

  draw(tick) {
    if (this.options.ground) keepAbove(this.camera, this.centre[1], LEAST_HEIGHT * this.size);
    sharpen(this.canvas, this.context);
    this.views = this.paint(this.context, tick);
  }

  paint(context, tick) {
    const own = this.context;
    this.context = context;
    const [areas, frames] = [this.areas(this.columns), this.clock.frames(tick)];
    const views = this.members.map((members, v) => this.drawView(areas[v], members, frames, tick));
    this.context = own;
    return views;
  }

  drawView(area, members, frames, tick) {
    const { context, clips, options, size } = this;
    const view = this.camera.view(area, this.target(members, frames));
    const [right, bottom, cell] = [area.x + area.width - MARGIN, area.y + area.height - MARGIN, cellOf(size)];
    context.save();
    context.beginPath();
    context.rect(area.x, area.y, area.width, area.height);
    context.clip();
    if (options.ground) drawGround(context, view, cell);
    if (options.ghosts) members.forEach((i) => this.drawGhosts(view, i, tick)); // behind all figures
    const shown = new Map(members.map((i) => [i, this.figure(i, frames[i])]));
    const away = (i) => view.project(shown.get(i)[0][0]).away;
    const order = [...members].sort((a, b) => away(b) - away(a)); // far ones first
    const figures = order.map((i) => {
      const [points, shows] = shown.get(i);
      if (options.trails) this.drawTrails(view, i, tick);
      const flat = drawFigure(context, view, points, clips[i].shape, {
        size: clips[i].size,
        shadow: options.ground,
        apart: this.overlaid,
        shows,
        colourOf: (joint) => this.colour(i, joint, tick),
      });
      const marked = clips[i].names.indexOf(options.joint);
      if (marked >= 0 && flat[marked + 1]) this.drawLabel(flat[marked + 1], clips[i].names[marked], area);
      if (this.hover?.clip === i && flat[this.hover.index]) drawRing(context, flat[this.hover.index]);
      return { clip: i, points, flat };
    }).sort((a, b) => a.clip - b.clip);
    if (options.axes) {
      const [x, y, z] = clips[members[0]].axes;
      drawAxes(context, view, options.place === "forward" ? ["", y, ""] : [x, y, z]); // the others turn with the root
    }
    if (options.ground) this.text(`grid ${Number(cell.toPrecision(3))} m`, right, bottom, "right");
    if (clips.length > 1) members.forEach((i, line) => this.drawName(i, area, line));
    if (this.showsSides(members)) drawSides(context, right, area.y + MARGIN + 8);
    context.restore();
    return { area, view, figures };
  }

  figure(i, moment) {
    return [this.clips[i].points(moment, this.options.place).map(this.aside(i)), (index) => this.clips[i].shows(moment, index)];
  }

  colour(i, joint, tick) {
    const { pairs } = this.clock;
    if (this.compares && (!this.overlaid || i === 1)) return heat(joint < 0 ? 0 : pairs.share(tick, i, joint));
    if (this.overlaid) return this.compares ? colours.middle : colours[`motion-${i % 5}`];
    return colours[this.clips[i].sides[joint] || "middle"];
  }

  /** Draw where joints were in the last second: the chosen one, or the ends of all limbs. */
  drawTrails(view, i, tick) {
    const { context, clock, options } = this;
    const clip = this.clips[i];
    const marked = clip.names.indexOf(options.joint);
    const first = Math.max(0, Math.floor(tick) - Math.round(TRAIL / clock.seconds));
    const stride = Math.max(1, Math.floor((tick - first) / 90)); // whole ticks
    const aside = this.aside(i);
    const point = (at, joint) => aside(clip.point(clock.frames(at)[i], joint + 1, options.place));
    context.lineWidth = 2;
    for (const joint of marked >= 0 ? [marked] : clip.ends) {
      context.strokeStyle = this.colour(i, joint, tick);
      for (let at = tick, before; at > first; at = before) {
        before = Math.max(first, Math.ceil(at - stride));
        if (![at, before].every((one) => clip.shows(clock.frames(one)[i], joint + 1))) continue;
        context.globalAlpha = 0.8 * (1 - (tick - at) / (tick - first + 1));
        context.beginPath();
        segment(context, view, point(at, joint), point(before, joint));
        context.stroke();
      }
    }
    context.globalAlpha = 1;
  }

  /** Draw the figure at some times before and after, paler the farther these are. */
  drawGhosts(view, i, tick) {
    const { clock, clips, context } = this;
    const step = Math.max(1, Math.round(GHOST / clock.seconds));
    for (const [times, alpha] of [[-3, 0.1], [2, 0.08], [-2, 0.16], [1, 0.14], [-1, 0.24]]) {
      const at = tick + times * step;
      if (at < 0 || at >= clock.count) continue;
      const [points, shows] = this.figure(i, clock.frames(at)[i]);
      const colourOf = (joint) => this.colour(i, joint, at);
      drawGhost(context, view, points, clips[i].shape, { alpha, shows, colourOf });
    }
  }

  text(words, x, y, align, colour = colours.quiet) {
    Object.assign(this.context, { font: FONT, textBaseline: "alphabetic", textAlign: align, fillStyle: colour });
    this.context.fillText(words, x, y);
  }

  shortened(words, width) {
    this.context.font = FONT;
    const letters = [...words.slice(0, 300)];
    const without = (n) => [...letters.slice(0, Math.ceil(n / 2)), "…", ...letters.slice(-Math.floor(n / 2))].join("");
    const fits = (text) => this.context.measureText(text).width <= width;
    if (words.length <= 300 && fits(words)) return words;
    let n = letters.length;
    while (n > 2 && !fits(without(n))) n--;
    return without(n);
  }

  /** Write the name of a motion, with its colour if all of it has one. */
  drawName(i, area, line) {
    const { context } = this;
    const [x, y] = [area.x + MARGIN, area.y + MARGIN + 8 + line * LINE];
    if (this.overlaid) {
      context.fillStyle = this.compares && i === 1 ? colours["heat-1"] : this.colour(i, -1, 0);
      context.fillRect(x, y - 10, 12, 11);
    }
    const from = x + (this.overlaid ? 19 : 0);
    const width = area.width - 2 * MARGIN - (this.overlaid ? 19 : 0) - (this.showsSides([i]) ? 80 : 0);
    this.text(this.shortened(this.clips[i].label, width), from, y, "left", colours.ink);
  }

  /** Mark the chosen joint and write its name, on the side where there is room. */
  drawLabel(point, name, area) {
    const { context } = this;
    drawRing(context, point);
    const words = this.shortened(name, Math.min(260, area.width / 2 - 20));
    const side = point.x > area.x + area.width / 2 ? -1 : 1;
    const textAlign = side < 0 ? "right" : "left";
    Object.assign(context, { strokeStyle: colours.paper, lineWidth: 4, font: FONT, textAlign });
    context.strokeText(words, point.x + 13 * side, point.y + 4);
    this.text(words, point.x + 13 * side, point.y + 4, textAlign, colours.ink);
  }

  point(x, y, within) {
    const inside = ({ area }) => x >= area.x && x < area.x + area.width && y >= area.y && y < area.y + area.height;
    this.hover = null;
    for (const { clip, flat } of this.views.find(inside)?.figures ?? []) {
      const index = nearestPoint(flat, x, y, within);
      if (index < 0) continue;
      within = Math.hypot(flat[index].x - x, flat[index].y - y);
      this.hover = { clip, index };
    }
  }
}
