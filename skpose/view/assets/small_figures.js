// Small figures among the points of an explorer: one for each group, with its name, where there is room for it, and as
// one zooms in poses, so many as have space. None lies over another.

const SMALL_GAP = 4; // px between two
const HALO = 9; // px, of the paper's colour around each
const SIDES = [68, 80, 92]; // px, of the square that a pose fills, where the zoom is 2, 4, and 8
const SCALE = { width: 190, height: 40 }; // px, of the lower left corner
const MOST_NAMED = 24; // groups that have a figure of their own; of more none has one
const KEPT = 1000; // pictures, after which all are made anew
const MS_OF_A_FRAME = 2; // ms of a frame in which pictures are made
const [NAME_FONT, NAME_LINE, NAME_LENGTH] = ["bold 13px system-ui, sans-serif", 15, 16]; // px, letters
const TONES = { left: 0.42, right: -0.32 }; // of the colour of a group: lighter and darker

class SmallFigures {
  /** `poses` are those of the page; `view` is the view of the large figure, whose direction the small ones have. */
  constructor(poses, view, size) {
    Object.assign(this, { poses, view, size, pictures: new Map(), figures: new Map(), groups: [], late: false });
    this.seen = "";
  }

  /** Take the groups of the colours, the largest first: the pose in the middle of each stands for it. */
  group(scatter, { names, of }) {
    const members = (names ?? []).map(() => []);
    if (names) of.forEach((group, row) => members[group].push(row));
    const found = members.map((rows, group) => ({ rows, words: linesOf(names[group] || "unnamed") }))
      .filter(({ rows }) => rows.length)
      .sort((a, b) => b.rows.length - a.rows.length);
    const shown = found.length > MOST_NAMED ? [] : found;
    this.groups = shown.map(({ rows, words }) => ({ row: medoidOf(scatter, rows), words }));
    this.labels = new Map();
  }

  /**
   * Draw those that have space; `colourOf` takes a row. Return their boxes and rows. With `all` it takes as long as it
   * needs; otherwise poses may be missing, then it is `late`.
   */
  draw(context, scatter, { colourOf, hidden, all }) {
    this.density = context.getTransform().a;
    this.forget(all);
    this.until = all ? Infinity : performance.now() + MS_OF_A_FRAME;
    const placed = this.placeNames(context, scatter)
      .filter(({ row }) => !hidden(row))
      .map((label) => boxOf(label, scatter.at(label.row)))
      .filter((box) => isInside(box, scatter));
    for (const box of placed) if (box.aside) drawLeader(context, scatter.at(box.row), box, colourOf(box.row));
    for (const box of placed) this.put(context, box, colourOf(box.row));
    const step = Math.floor(Math.log2(scatter.zoom));
    const side = SIDES[Math.min(step, SIDES.length) - 1];
    for (const row of step < 1 ? [] : nearCells(scatter, side + SMALL_GAP)) {
      if (hidden(row)) continue;
      const fits = (size) => {
        const box = boxOf({ row, side, offset: [0, 0], ...size }, scatter.at(row));
        return isInside(box, scatter) && !placed.some((other) => overlap(box, other)) && box;
      };
      const box = fits({ width: 0.3 * side, height: 0.5 * side }) && fits(this.extent(row, side));
      if (!box) continue;
      placed.push(box);
      this.put(context, box, colourOf(row));
    }
    return placed;
  }

  /** The labels of groups, each with its size and where it is from its point; the same until the zoom has doubled. */
  placeNames(context, scatter) {
    const { width, height } = scatter;
    const zoom = 2 ** Math.floor(Math.log2(scatter.zoom));
    const key = `${zoom} ${width} ${height} ${this.seen}`;
    if (this.labels.has(key)) return this.labels.get(key);
    context.font = NAME_FONT;
    const side = Math.max(60, Math.min(100, Math.round(0.125 * Math.min(width, height))));
    const asked = this.groups.map(({ row, words }) => {
      const extent = this.extent(row, side);
      const widest = Math.max(extent.width, ...words.map((line) => context.measureText(line).width));
      return { row, words, side, extent, width: widest, height: extent.height + NAME_LINE * words.length + 1 };
    });
    this.labels.set(key, placeLabels(scatter, asked, zoom));
    return this.labels.get(key);
  }

  /** Forget the pictures where the colours or the direction are others; the direction follows once it rests. */
  forget(all) {
    const { azimuth, elevation } = this.view.camera;
    const asked = `${azimuth} ${elevation}`;
    const rests = all || !this.seen || asked === this.asked;
    this.asked = asked;
    this.late = asked !== this.seen && !rests;
    if (asked !== this.seen && rests) {
      Object.assign(this, { seen: asked, direction: { azimuth, elevation } });
      this.figures.clear();
      this.labels.clear();
    }
    const look = `${this.seen} ${colours.paper} ${this.density}`;
    if (look !== this.look || this.pictures.size > KEPT) this.pictures.clear();
    this.look = look;
  }

  /** The points of a pose and how the camera sees them in a square of side 1. */
  figure(row) {
    if (this.figures.has(row)) return this.figures.get(row);
    const points = this.poses.points(this.poses.pose(row));
    const { shape } = this.poses.data.skeleton;
    const around = reachOf(shape, points, () => true);
    const centre = centreOfBox(around);
    const camera = Object.assign(new Camera(), this.direction);
    const area = { x: 0, y: 0, width: 1, height: 1 };
    const moved = around.map((point) => point.map((value, axis) => value - centre[axis]));
    camera.distance = Math.max(camera.distanceTo(moved, area), 1.7 * this.size);
    const view = camera.view(area, centre);
    const discs = centresOf(shape, points, () => true).map((at, i) => {
      const { x, y, scale } = view.project(at);
      return { x, y, radius: shape.spheres[i].radius * scale };
    });
    const [left, right, top, bottom] = [["x", -1], ["x", 1], ["y", -1], ["y", 1]].map(([axis, sign]) =>
      sign * Math.max(...discs.map((disc) => sign * disc[axis] + disc.radius)));
    const made = { points, camera, centre, left, top, width: right - left, height: bottom - top };
    this.figures.set(row, made);
    return made;
  }

  extent(row, side) {
    const { width, height } = this.figure(row);
    return { width: side * width, height: side * height };
  }

  put(context, box, colour) {
    const key = `${box.row} ${colour} ${box.side} ${box.words}`;
    if (!this.pictures.has(key)) {
      if (!box.words && performance.now() > this.until) return (this.late = true);
      this.pictures.set(key, this.picture(box, colour));
    }
    const { x, y, width, height } = box;
    context.drawImage(this.pictures.get(key), x - HALO, y - HALO, width + 2 * HALO, height + 2 * HALO);
  }

  picture({ row, side, width, height, words = [] }, colour) {
    const { density } = this;
    const [drawn, picture] = [0, 1].map(() => Object.assign(document.createElement("canvas"), {
      width: Math.ceil((width + 2 * HALO) * density), height: Math.ceil((height + 2 * HALO) * density),
    }));
    const context = drawn.getContext("2d");
    context.scale(density, density);
    context.translate(HALO + width / 2, HALO);
    const { points, camera, centre, left, top, width: share } = this.figure(row);
    const { shape, sides } = this.poses.data.skeleton;
    const area = { x: -side * (left + share / 2), y: -side * top, width: side, height: side };
    const colourOf = (joint) => (TONES[sides[joint]] ? toneOf(colour, TONES[sides[joint]]) : colour);
    drawFigure(context, camera.view(area, centre), points, shape, { size: this.size, colourOf });
    Object.assign(context, { font: NAME_FONT, textAlign: "center", textBaseline: "bottom", fillStyle: colour });
    words.forEach((line, i) => context.fillText(line, 0, height - NAME_LINE * (words.length - 1 - i)));
    const onto = picture.getContext("2d");
    Object.assign(onto, { shadowColor: colours.paper, shadowOffsetX: picture.width });
    for (const blur of [2, 2, 4, 4, 8, 8]) { // shadows alone: what is over each other is opaque near the figure
      onto.shadowBlur = blur * density;
      onto.drawImage(drawn, -picture.width, 0);
    }
    Object.assign(onto, { shadowColor: "transparent" });
    onto.drawImage(drawn, 0, 0);
    return picture;
  }
}

const boxOf = (figure, [x, y]) => ({
  ...figure, x: x + figure.offset[0] - figure.width / 2, y: y + figure.offset[1] - figure.height / 2,
});

const isInside = (box, { width, height }) => box.x >= 0 && box.y >= 0 && box.x + box.width <= width
  && box.y + box.height <= height - (box.x < SCALE.width ? SCALE.height : 0);

const overlap = (a, b) => Math.abs(a.x + a.width / 2 - b.x - b.width / 2) < (a.width + b.width) / 2 + SMALL_GAP
  && Math.abs(a.y + a.height / 2 - b.y - b.height / 2) < (a.height + b.height) / 2 + SMALL_GAP;

function linesOf(name) {
  const words = name.split(" ");
  let n = words.length;
  while (n > 1 && words.slice(0, n).join(" ").length > NAME_LENGTH) n--;
  const lines = [words.slice(0, n), words.slice(n)].map((some) => some.join(" ")).filter(Boolean);
  return lines.map((line) => (line.length > NAME_LENGTH ? `${line.slice(0, NAME_LENGTH - 1)}…` : line));
}

/** Draw a thin line from a point to its label. */
function drawLeader(context, [x, y], { extent, ...box }, colour) {
  const [toX, toY] = [box.x + box.width / 2 - x, box.y + extent.height / 2 - y];
  const halves = [extent.width / 2 + 2, (toY < 0 ? box.height - extent.height / 2 : extent.height / 2) + 2];
  const share = Math.max(0, 1 - Math.min(halves[0] / Math.abs(toX), halves[1] / Math.abs(toY)));
  for (const [lineWidth, strokeStyle] of [[4, colours.paper], [1.5, colour]]) {
    Object.assign(context, { lineWidth, strokeStyle });
    polyline(context, [[x, y], [x + share * toX, y + share * toY]]);
  }
  dot(context, [x, y], 5, colour);
}

/** Of some points the one that is nearest to the medians of their places. */
function medoidOf({ x, y }, rows) {
  const median = (values) => Float64Array.from(rows, (row) => values[row]).sort()[rows.length >> 1];
  const [middleX, middleY] = [median(x), median(y)];
  const far = (row) => (x[row] - middleX) ** 2 + (y[row] - middleY) ** 2;
  return rows.reduce((best, row) => (far(row) < far(best) ? row : best));
}

/**
 * The point nearest to the middle of each cell of a grid of the plane, cells about so many px wide. The cells halve
 * where the zoom doubles, so that figures stay while one moves.
 */
function nearCells({ scale, count, x, y, cells, absent }, side) {
  const cell = 2 ** Math.ceil(Math.log2(side / scale));
  const found = new Map();
  for (let i = 0; i < count; i++) {
    if (!cells[i] || absent?.[i]) continue; // or not seen
    const [column, row] = [Math.floor(x[i] / cell), Math.floor(y[i] / cell)];
    const far = Math.hypot(x[i] / cell - column - 0.5, y[i] / cell - row - 0.5);
    const known = found.get(65536 * column + row);
    if (far < (known?.far ?? 0.5)) found.set(65536 * column + row, { far, i, column, row });
  }
  return [...found.values()].sort((a, b) => a.column - b.column || a.row - b.row).map(({ i }) => i);
}
