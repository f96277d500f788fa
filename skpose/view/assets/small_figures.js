// Small figures among the points of an explorer: one for each group, with its name, and as one zooms in poses, so many
// as have space. None lies over another.

const SMALL_SIDE = 64; // px, of the square that a small figure fills
const SMALL_GAP = 4; // px between two
const ZOOM_OF_POSES = 2; // from which poses are shown
const MOST_NAMED = 24; // groups that have a figure of their own; of more none has one
const KEPT = 400; // pictures that are kept
const NAME_FONT = "bold 13px system-ui, sans-serif";

class SmallFigures {
  /** `poses` are those of the page; `view` is the view of the large figure, whose direction the small ones have. */
  constructor(poses, view, size) {
    Object.assign(this, { poses, view, size, pictures: new Map(), groups: [] });
    this.cameras = "";
  }

  /** Take the groups of the colours, the largest first: the pose in the middle of each stands for it. */
  group(scatter, { names, of }) {
    const members = (names ?? []).map(() => []);
    if (names) of.forEach((group, row) => members[group].push(row));
    const found = members.map((rows, group) => ({ rows, words: shortened(names[group] || "unnamed") }))
      .filter(({ rows }) => rows.length)
      .sort((a, b) => b.rows.length - a.rows.length);
    const shown = found.length > MOST_NAMED ? [] : found;
    this.groups = shown.map(({ rows, words }) => ({ row: medoidOf(scatter, rows), words }));
  }

  /** Draw those that have space; `colourOf` takes a row. Return their rows. */
  draw(context, scatter, { colourOf, hidden }) {
    this.forget(scatter);
    const placed = [];
    const fits = (box) => box.x >= 0 && box.y >= 0 && box.x + box.width <= scatter.width
      && box.y + box.height <= scatter.height && placed.every((other) => !overlap(box, other));
    const rows = [];
    context.font = NAME_FONT;
    for (const { row, words } of this.groups) {
      const box = boxAt(scatter.at(row), Math.max(0.7 * SMALL_SIDE, context.measureText(words).width), SMALL_SIDE + 16);
      if (hidden(row) || !fits(box)) continue;
      placed.push(box);
      rows.push(row);
      clear(context, box); // of the points
      this.put(context, box, row, colourOf(row));
      this.name(context, box, words, colourOf(row));
    }
    if (scatter.zoom < ZOOM_OF_POSES) return rows;
    for (const row of nearCells(scatter, SMALL_SIDE + SMALL_GAP)) {
      if (hidden(row)) continue;
      const box = boxAt(scatter.at(row), 0.7 * SMALL_SIDE, SMALL_SIDE);
      if (!fits(box)) continue;
      placed.push(box);
      rows.push(row);
      this.put(context, box, row, colourOf(row));
    }
    return rows;
  }

  /** Forget the pictures where the colours or the direction are others. */
  forget() {
    const { azimuth, elevation } = this.view.camera;
    const now = `${colours.paper} ${azimuth} ${elevation} ${window.devicePixelRatio}`;
    if (now !== this.cameras || this.pictures.size > KEPT) this.pictures.clear();
    this.cameras = now;
  }

  put(context, { x, y, width }, row, colour) {
    const key = `${row} ${colour}`;
    if (!this.pictures.has(key)) this.pictures.set(key, this.picture(row, colour));
    context.globalAlpha = 0.9;
    context.drawImage(this.pictures.get(key), x + (width - SMALL_SIDE) / 2, y, SMALL_SIDE, SMALL_SIDE);
    context.globalAlpha = 1;
  }

  /** The picture of a pose in one colour, on nothing. */
  picture(row, colour) {
    const density = window.devicePixelRatio || 1;
    const side = SMALL_SIDE * density;
    const canvas = Object.assign(document.createElement("canvas"), { width: side, height: side });
    const context = canvas.getContext("2d");
    context.scale(density, density);
    const points = this.poses.points(this.poses.pose(row));
    const { shape } = this.poses.data.skeleton;
    const around = reachOf(shape, points, () => true);
    const centre = [0, 1, 2].map((axis) => {
      const values = around.map((point) => point[axis]);
      return (Math.min(...values) + Math.max(...values)) / 2;
    });
    const camera = Object.assign(new Camera(), this.view.camera, { zoom: 1, shift: [0, 0] });
    const area = { x: 0, y: 0, width: SMALL_SIDE, height: SMALL_SIDE };
    const moved = around.map((point) => point.map((value, axis) => value - centre[axis]));
    camera.distance = Math.max(camera.distanceTo(moved, area), 0.5 * this.size);
    drawFigure(context, camera.view(area, centre), points, shape, { size: this.size, colourOf: () => colour });
    return canvas;
  }

  /** Write the name of a group below its figure. */
  name(context, { x, y, width }, words, colour) {
    Object.assign(context, {
      font: NAME_FONT, textAlign: "center", textBaseline: "top", lineJoin: "round",
      lineWidth: 4, strokeStyle: colours.paper, fillStyle: colour,
    });
    context.strokeText(words, x + width / 2, y + SMALL_SIDE);
    context.fillText(words, x + width / 2, y + SMALL_SIDE);
  }
}

const boxAt = ([x, y], width, height) => ({ x: x - width / 2, y: y - height / 2, width, height });

const overlap = (a, b) => Math.abs(a.x + a.width / 2 - b.x - b.width / 2) < (a.width + b.width) / 2 + SMALL_GAP
  && Math.abs(a.y + a.height / 2 - b.y - b.height / 2) < (a.height + b.height) / 2 + SMALL_GAP;

const shortened = (words) => (words.length > 14 ? `${words.slice(0, 13)}…` : words);

/** Let what lies below a box step back. */
function clear(context, { x, y, width, height }) {
  context.globalAlpha = 0.7;
  context.fillStyle = colours.paper;
  context.beginPath();
  context.roundRect(x - SMALL_GAP / 2, y - SMALL_GAP / 2, width + SMALL_GAP, height + SMALL_GAP, 8);
  context.fill();
  context.globalAlpha = 1;
}

/** Of some points the one that is nearest to the medians of their places. */
function medoidOf({ x, y }, rows) {
  const median = (values) => Float64Array.from(rows, (row) => values[row]).sort()[rows.length >> 1];
  const [middleX, middleY] = [median(x), median(y)];
  const far = (row) => (x[row] - middleX) ** 2 + (y[row] - middleY) ** 2;
  return rows.reduce((best, row) => (far(row) < far(best) ? row : best));
}

/**
 * The point nearest to the middle of each cell of a grid of the plane, cells about so many px wide. The grid is that of
 * the plane and its cells halve where the zoom doubles, so that figures stay while one moves.
 */
function nearCells(scatter, side) {
  const cell = 2 ** Math.ceil(Math.log2(side / scatter.scale));
  const [left, top] = scatter.placeOf(0, 0);
  const [right, bottom] = scatter.placeOf(scatter.width, scatter.height);
  const rows = [];
  for (let i = Math.floor(left / cell); i * cell <= right; i++) {
    for (let k = Math.floor(bottom / cell); k * cell <= top; k++) {
      const row = scatter.grid.nearest((i + 0.5) * cell, (k + 0.5) * cell, 0.5 * cell, scatter.absent);
      if (row >= 0) rows.push(row);
    }
  }
  return rows;
}
