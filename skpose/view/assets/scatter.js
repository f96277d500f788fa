// Points in the plane: drawn into the pixels of a canvas, found by a grid, chosen by a polygon.

const MARGIN = 28; // px around all points
const [LEAST_ZOOM, MOST_ZOOM] = [0.5, 200];
const CELL = 10; // px, in which points are counted
const OWN = 0.25; // what a point adds to its own cell
// How much smaller and paler points are where they cover the plane more than once: what all of them cover, as they lie
// over each other, grows by the logarithm of their number, so that there are differences where there are many.
const [THIN, LEVELS_OF_TWO] = [0.5, 3];
const SHARES = Array.from({ length: 25 }, (_, level) => {
  const crowd = 2 ** (level / LEVELS_OF_TWO) - 1;
  const share = crowd ? Math.log1p(crowd) / crowd : 1;
  const size = Math.max(0.65, share ** 0.25);
  return [size, share / size ** 2];
});

/**
 * Points that can be moved and zoomed. `canvas` takes the pointer and the marks; `layer`, under it, has the points,
 * and is drawn only where the view or the colours change.
 */
class Scatter {
  zoom = 1;
  centre = [0, 0]; // of the view, in units of the points
  faded = null; // for each point whether it steps back, or null
  absent = null; // for each point whether it cannot be chosen either, or null

  constructor(layer, canvas, count) {
    Object.assign(this, { layer, canvas, count, x: new Float64Array(count), y: new Float64Array(count) });
    this.context = layer.getContext("2d", { alpha: false });
    this.colours = new Uint32Array(count); // 0xBBGGRR
    this.forms = new Uint8Array(count); // of the points, by their place among FORMS
    this.order = mixed(count);
  }

  /** Take other places of the points: a table of two columns. */
  place(table) {
    for (let i = 0; i < this.count; i++) [this.x[i], this.y[i]] = [table.at(i, 0), table.at(i, 1)];
    this.grid = new Grid(this.x, this.y);
    this.home();
  }

  home() {
    this.zoomTo(1, this.middle);
  }

  get middle() {
    const { low, high } = this.grid;
    return [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
  }

  get isHome() {
    return !this.grid || (this.zoom === 1 && this.middle.every((value, axis) => value === this.centre[axis]));
  }

  get width() {
    return this.canvas.clientWidth;
  }

  get height() {
    return this.canvas.clientHeight;
  }

  /** px in a unit of the points; the same along both axes. */
  get scale() {
    const { low, high } = this.grid;
    const fits = [this.width, this.height].map((length, axis) =>
      Math.max(length - 2 * MARGIN, 1) / (high[axis] - low[axis] || 1e-9));
    return Math.min(...fits, 1e12) * this.zoom;
  }

  /** Where a place of the plane is in the canvas, px. */
  seen([x, y], scale = this.scale) {
    return [this.width / 2 + scale * (x - this.centre[0]), this.height / 2 - scale * (y - this.centre[1])];
  }

  /** Where a point is in the canvas, px. */
  at(i) {
    return this.seen([this.x[i], this.y[i]]);
  }

  /** The place of the plane that is at a place of the canvas. */
  placeOf(x, y) {
    const { scale } = this;
    return [this.centre[0] + (x - this.width / 2) / scale, this.centre[1] - (y - this.height / 2) / scale];
  }

  pan(dx, dy) {
    const { scale } = this;
    this.centre = [this.centre[0] - dx / scale, this.centre[1] + dy / scale];
  }

  /** Zoom such that what is at a place of the canvas stays there. */
  zoomBy(factor, x = this.width / 2, y = this.height / 2) {
    const kept = this.placeOf(x, y);
    this.zoom = Math.max(LEAST_ZOOM, Math.min(MOST_ZOOM, this.zoom * factor));
    const now = this.placeOf(x, y);
    this.centre = this.centre.map((value, axis) => value + kept[axis] - now[axis]);
  }

  /** Have a zoom and a place in the middle. */
  zoomTo(zoom, centre) {
    Object.assign(this, { zoom: Math.max(LEAST_ZOOM, Math.min(MOST_ZOOM, zoom)), centre });
  }

  /** Move the view if a point is outside of it. */
  show(i) {
    const [x, y] = this.at(i);
    const outside = (value, length) => Math.min(0, value - MARGIN) + Math.max(0, value - length + MARGIN);
    const [dx, dy] = [outside(x, this.width), outside(y, this.height)];
    if (dx || dy) this.pan(-dx, -dy);
  }

  /** The index of the point that is nearest to a place of the canvas, within some px, or -1. */
  nearest(x, y, within) {
    return this.grid.nearest(...this.placeOf(x, y), within / this.scale, this.absent);
  }

  /** The nearest point to the left or right, up or down, of a point; the point itself if there is none. */
  next(i, right, up) {
    let [best, least] = [i, Infinity];
    for (let k = 0; k < this.count; k++) {
      const [dx, dy] = [this.x[k] - this.x[i], this.y[k] - this.y[i]];
      const along = right * dx + up * dy;
      const far = along + 2 * Math.abs(right * dy - up * dx);
      if (!this.absent?.[k] && along > Math.abs(right * dy - up * dx) && far < least) [best, least] = [k, far];
    }
    return best;
  }

  /** The points inside of a polygon, by the even-odd rule; its corners are places of the plane. */
  inside(corners) {
    const found = [];
    const bounds = [0, 1].map((axis) => corners.map((corner) => corner[axis]));
    const [[left, right], [low, high]] = bounds.map((values) => [Math.min(...values), Math.max(...values)]);
    for (let i = 0; i < this.count; i++) {
      const [x, y] = [this.x[i], this.y[i]];
      if (this.absent?.[i]) continue;
      if (x >= left && x <= right && y >= low && y <= high && contains(corners, x, y)) found.push(i);
    }
    return found;
  }

  /** Radius of a point, px. */
  get radius() {
    return (this.count > 3000 ? 2.4 : 3.2) * Math.min(2, Math.max(1, this.zoom ** 0.25));
  }

  /** Draw all points. */
  draw() {
    const density = window.devicePixelRatio || 1;
    const [width, height] = [this.width, this.height].map((length) => Math.max(1, Math.round(length * density)));
    if (this.layer.width !== width || this.layer.height !== height || !this.image) {
      Object.assign(this.layer, { width, height });
      this.image = this.context.createImageData(width, height);
    }
    this.fill(this.image, density, 255);
    this.context.putImageData(this.image, 0, 0);
  }

  /** Draw all points, those that step back first, into a picture on paper of an opacity, 0 to 255. */
  fill(image, density, opacity) {
    const { width, height } = image;
    const paper = packedColour(colours.paper);
    const pixels = new Uint32Array(image.data.buffer).fill((opacity << 24) | paper);
    const scale = this.scale * density;
    const [x0, y0] = [width / 2 - scale * this.centre[0], height / 2 + scale * this.centre[1]];
    const radius = this.radius * density;
    const levels = this.crowding();
    const { cells } = this;
    for (const back of this.faded || this.absent ? [1, 0] : [0]) {
      const stamps = FORMS.map((form) => SHARES.map(([size, cover]) => stampOf(form, size * radius, cover, width)));
      for (const i of this.order) {
        if (!cells[i] || (this.faded?.[i] || this.absent?.[i] || 0) !== back) continue;
        const colour = back ? blend(paper, this.colours[i], 56) : this.colours[i];
        const x = Math.round(x0 + scale * this.x[i]);
        const y = Math.round(y0 - scale * this.y[i]);
        stamp(pixels, image, stamps[this.forms[i]][levels[i]], x, y, colour);
      }
    }
  }

  /**
   * How crowded each point that is seen is at this zoom, as a place in SHARES. Points are counted in cells of the
   * plane, which stay as one moves, and each cell takes its neighbours' into account, so that no cell is seen.
   */
  crowding() {
    const { x, y, count, width, height, absent } = this;
    this.cells ??= new Uint32Array(count); // 0 for those that are not seen
    this.levels ??= new Uint8Array(count);
    const { cells, levels } = this;
    const perCell = this.scale / CELL; // cells in a unit of the points
    const [left, low] = this.placeOf(0, height).map((value) => Math.floor(value * perCell) - 2);
    const [columns, rows] = [width, height].map((length) => Math.ceil(length / CELL) + 5); // with an edge
    const counts = new Float32Array(columns * rows);
    for (let i = 0; i < count; i++) {
      const column = Math.floor(x[i] * perCell) - left;
      const row = Math.floor(y[i] * perCell) - low;
      const cell = column > 0 && row > 0 && column < columns && row < rows ? row * columns + column : 0;
      cells[i] = cell;
      if (!absent?.[i]) counts[cell]++;
    }
    counts[0] = 0; // those that are not seen
    const around = smooth(smooth(counts, 1), columns); // 1, 2, 1 of 4 along both axes
    const covers = (Math.PI * this.radius ** 2) / CELL ** 2; // of a cell, by a point
    const levelOf = around.map((some) => {
      const crowd = (covers * (some - OWN)) / THIN;
      return crowd > 0 ? Math.min(SHARES.length - 1, Math.round(LEVELS_OF_TWO * Math.log2(1 + crowd))) : 0;
    });
    for (let i = 0; i < count; i++) levels[i] = levelOf[cells[i]];
    return levels;
  }
}

/** Half of each number and a quarter of those before and after. */
function smooth(values, stride) {
  const made = new Float32Array(values.length);
  for (let i = stride; i < values.length - stride; i++) {
    made[i] = 0.25 * (values[i - stride] + 2 * values[i] + values[i + stride]);
  }
  return made;
}

/** Draw one point into the pixels of a picture. */
function stamp(pixels, { width, height }, { reach, columns, rows, places, cover }, x, y, colour) {
  if (x < -reach || y < -reach || x >= width + reach || y >= height + reach) return;
  const whole = x >= reach && y >= reach && x < width - reach && y < height - reach;
  const middle = y * width + x;
  for (let k = 0; k < cover.length; k++) {
    if (!whole) {
      const [column, row] = [x + columns[k], y + rows[k]];
      if (column < 0 || row < 0 || column >= width || row >= height) continue;
    }
    const at = middle + places[k];
    pixels[at] = 0xff000000 | (cover[k] === 256 ? colour : blend(pixels[at], colour, cover[k]));
  }
}

/** A colour, 0xBBGGRR, that is so many 256ths of the way from one to another. */
function blend(from, to, share) {
  const rest = 256 - share;
  const redAndBlue = ((from & 0xff00ff) * rest + (to & 0xff00ff) * share) >>> 8;
  const green = ((from & 0x00ff00) * rest + (to & 0x00ff00) * share) >>> 8;
  return (redAndBlue & 0xff00ff) | (green & 0x00ff00);
}

/** A colour "#rrggbb" or "rgb(r g b)" as 0xBBGGRR. */
function packedColour(text) {
  const [r, g, b] = text.startsWith("#")
    ? [1, 3, 5].map((from) => parseInt(text.slice(from, from + 2), 16))
    : text.match(/\d+/g).map(Number);
  return r | (g << 8) | (b << 16);
}

// Forms of points, each as how far a place is outside of it, for a radius.
const FORMS = [
  (x, y, radius) => Math.hypot(x, y) - radius,
  (x, y, radius) => Math.max(y - 0.75 * radius, 0.87 * Math.abs(x) - 0.5 * y - 0.75 * radius), // a triangle
  (x, y, radius) => Math.max(Math.abs(x), Math.abs(y)) - 0.9 * radius, // a square
];

/** The pixels that a form covers, about its middle and in a picture of a width, and by how many 256ths each. */
function stampOf(form, radius, opacity, width) {
  const reach = Math.ceil(1.3 * radius + 0.5);
  const [columns, rows, places, cover] = [[], [], [], []];
  for (let row = -reach; row <= reach; row++) {
    for (let column = -reach; column <= reach; column++) {
      const share = Math.round(256 * opacity * Math.max(0, Math.min(1, 0.5 - form(column, row, radius))));
      if (!share) continue;
      columns.push(column);
      rows.push(row);
      places.push(row * width + column);
      cover.push(share);
    }
  }
  return { reach, columns: Int32Array.from(columns), rows: Int32Array.from(rows), places: Int32Array.from(places),
    cover: Uint16Array.from(cover) };
}

/** The numbers below n in an order in which no group of points covers another one: multiples of a large prime. */
function mixed(n) {
  const stride = n % 7919 ? 7919 : 7907;
  const order = new Uint32Array(n);
  for (let i = 1; i < n; i++) order[i] = (order[i - 1] + stride) % n;
  return order;
}

/** Whether a place is inside of a polygon, by the even-odd rule. */
function contains(corners, x, y) {
  let inside = false;
  for (let i = 0, j = corners.length - 1; i < corners.length; j = i++) {
    const [[x1, y1], [x2, y2]] = [corners[i], corners[j]];
    if (y1 > y !== y2 > y && x < x1 + ((x2 - x1) * (y - y1)) / (y2 - y1)) inside = !inside;
  }
  return inside;
}

/** Cells of the plane with the points in each, one after another in `members`. */
class Grid {
  constructor(x, y) {
    const bounds = (values) => [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
    const [[lowX, highX], [lowY, highY]] = [bounds(x), bounds(y)];
    const side = Math.max(1, Math.floor(Math.sqrt(x.length / 2))); // cells in a row
    Object.assign(this, { x, y, side, low: [lowX, lowY], high: [highX, highY] });
    this.starts = new Uint32Array(side * side + 1);
    const cells = Uint32Array.from(x, (value, i) => this.row(y[i], 1) * side + this.row(value, 0));
    for (const cell of cells) this.starts[cell + 1]++;
    for (let cell = 0; cell < side * side; cell++) this.starts[cell + 1] += this.starts[cell];
    const filled = this.starts.slice();
    this.members = new Uint32Array(x.length);
    cells.forEach((cell, i) => (this.members[filled[cell]++] = i));
  }

  /** The row or column of cells that has a coordinate, or the one next to it. */
  row(value, axis) {
    const extent = this.high[axis] - this.low[axis];
    const row = extent > 0 ? Math.floor((this.side * (value - this.low[axis])) / extent) : 0;
    return Math.max(0, Math.min(this.side - 1, row));
  }

  /** The index of the point that is nearest to a place, within a distance, of those that are not absent, or -1. */
  nearest(x, y, within, absent) {
    let [best, least] = [-1, within * within];
    const [left, right] = [this.row(x - within, 0), this.row(x + within, 0)];
    for (let row = this.row(y - within, 1); row <= this.row(y + within, 1); row++) {
      const first = this.starts[row * this.side + left];
      const end = this.starts[row * this.side + right + 1];
      for (let k = first; k < end; k++) {
        const i = this.members[k];
        if (absent?.[i]) continue;
        const [dx, dy] = [this.x[i] - x, this.y[i] - y];
        const far = dx * dx + dy * dy;
        if (far < least) [best, least] = [i, far];
      }
    }
    return best;
  }
}
