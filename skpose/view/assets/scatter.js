// Points in the plane: drawn as small pictures, found by their places, chosen by a polygon.

const MARGIN = 28; // px around all points
const [LEAST_ZOOM, MOST_ZOOM] = [0.5, 200];
const CELL = 10; // px, in which points are counted
const OWN = 0.25; // what a point adds to its own cell
const PALE = "22%"; // of the colour of points that step back; the rest is that of the paper
// How much smaller and paler points are where they cover the plane more than once: what all of them cover, as they lie
// over each other, grows by the logarithm of their number, so that there are differences where there are many.
const [THIN, LEVELS_OF_TWO] = [0.5, 3];
const SHARES = Array.from({ length: 25 }, (_, level) => {
  const crowd = 2 ** (level / LEVELS_OF_TWO) - 1;
  const share = crowd ? Math.log1p(crowd) / crowd : 1;
  const size = Math.max(0.65, share ** 0.25);
  return [size, share / size ** 2];
});
// Forms of points: a circle, a triangle and a square by their corners, for a radius of one.
const FORMS = [null, [[0, -1.5], [1.3, 0.75], [-1.3, 0.75]], [[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]];

function fillForm(context, form, x, y, radius) {
  context.beginPath();
  if (form) for (const [dx, dy] of FORMS[form]) context.lineTo(x + radius * dx, y + radius * dy);
  else context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}

/**
 * Points that can be moved and zoomed. `canvas` takes the pointer and the marks; `layer`, under it, has the points,
 * and is drawn only where the view or the colours change.
 */
class Scatter {
  zoom = 1;
  centre = [0, 0]; // of the view, in units of the points
  faded = null; // for each point whether it steps back, or null
  absent = null; // for each point whether it cannot be chosen either, or null
  palette = []; // colours

  constructor(layer, canvas, count) {
    Object.assign(this, { layer, canvas, count, x: new Float64Array(count), y: new Float64Array(count) });
    this.context = layer.getContext("2d");
    this.colours = new Uint8Array(count); // of the points, by their places in the palette
    this.forms = new Uint8Array(count); // by their places among FORMS
    this.cells = new Uint32Array(count); // 0 for those that are not seen
    this.order = mixed(count);
  }

  /** Take other places of the points: a table of two columns. */
  place(table) {
    for (let i = 0; i < this.count; i++) [this.x[i], this.y[i]] = [table.at(i, 0), table.at(i, 1)];
    const bounds = (values, of) => values.reduce((a, b) => of(a, b));
    [this.low, this.high] = [Math.min, Math.max].map((of) => [bounds(this.x, of), bounds(this.y, of)]);
    this.home();
  }

  home() {
    this.zoomTo(1, this.middle);
  }

  get middle() {
    return this.low.map((low, axis) => (low + this.high[axis]) / 2);
  }

  get isHome() {
    return !this.low || (this.zoom === 1 && this.middle.every((value, axis) => value === this.centre[axis]));
  }

  get width() {
    return this.canvas.clientWidth;
  }

  get height() {
    return this.canvas.clientHeight;
  }

  get scale() {
    const { low, high } = this;
    const fits = [this.width, this.height].map((length, axis) =>
      Math.max(length - 2 * MARGIN, 1) / (high[axis] - low[axis] || 1e-9));
    return Math.min(...fits, 1e12) * this.zoom;
  }

  seen([x, y], scale = this.scale) {
    return [this.width / 2 + scale * (x - this.centre[0]), this.height / 2 - scale * (y - this.centre[1])];
  }

  at(i) {
    return this.seen([this.x[i], this.y[i]]);
  }

  placeOf(x, y) {
    const { scale } = this;
    return [this.centre[0] + (x - this.width / 2) / scale, this.centre[1] - (y - this.height / 2) / scale];
  }

  pan(dx, dy) {
    const { scale } = this;
    this.centre = [this.centre[0] - dx / scale, this.centre[1] + dy / scale];
  }

  zoomBy(factor, x = this.width / 2, y = this.height / 2) {
    const kept = this.placeOf(x, y);
    this.zoom = Math.max(LEAST_ZOOM, Math.min(MOST_ZOOM, this.zoom * factor));
    const now = this.placeOf(x, y);
    this.centre = this.centre.map((value, axis) => value + kept[axis] - now[axis]);
  }

  zoomTo(zoom, centre) {
    Object.assign(this, { zoom: Math.max(LEAST_ZOOM, Math.min(MOST_ZOOM, zoom)), centre });
  }

  show(i) {
    const [x, y] = this.at(i);
    const outside = (value, length) => Math.min(0, value - MARGIN) + Math.max(0, value - length + MARGIN);
    const [dx, dy] = [outside(x, this.width), outside(y, this.height)];
    if (dx || dy) this.pan(-dx, -dy);
  }

  /** The index of the nearest point to a place of the canvas, within some px, or -1. */
  nearest(x, y, within) {
    const [[u, v], { absent, count }] = [this.placeOf(x, y), this];
    let [best, least] = [-1, (within / this.scale) ** 2];
    for (let i = 0; i < count; i++) {
      const far = (this.x[i] - u) ** 2 + (this.y[i] - v) ** 2;
      if (far < least && !absent?.[i]) [best, least] = [i, far];
    }
    return best;
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
    const all = Array.from({ length: this.count }, (_, i) => i);
    return all.filter((i) => !this.absent?.[i] && contains(corners, this.x[i], this.y[i]));
  }

  get radius() {
    return (this.count > 3000 ? 2.4 : 3.2) * Math.min(2, Math.max(1, this.zoom ** 0.25));
  }

  draw() {
    sharpen(this.layer, this.context);
    this.context.putImageData(this.imageOf(this.context.getTransform().a), 0, 0);
  }

  /** Draw all points into any canvas whose unit is a px of the page. */
  paint(context) {
    const image = this.imageOf(context.getTransform().a);
    const { width, height } = image;
    const points = Object.assign(document.createElement("canvas"), { width, height });
    points.getContext("2d").putImageData(image, 0, 0);
    context.save();
    context.resetTransform();
    context.drawImage(points, 0, 0);
    context.restore();
  }

  /** All points, those that step back first, on nothing; the next call draws into the same image. */
  imageOf(density) {
    const scale = this.scale * density;
    const [x0, y0] = [this.width, this.height].map((length) => (length * density) / 2);
    const [width, height] = [x0, y0].map((half) => Math.max(1, Math.ceil(2 * half)));
    if (this.image?.width === width && this.image.height === height) this.image.data.fill(0);
    else this.image = new ImageData(width, height);
    const levels = this.crowding();
    const radius = Math.round(4 * this.radius * density) / 4;
    const look = `${radius} ${colours.paper} ${this.palette}`;
    if (look !== this.look) Object.assign(this, { look, pictures: [[], []] });
    const { x, y, centre, cells, colours: shades, forms, faded, absent } = this;
    for (const back of faded || absent ? [1, 0] : [0]) {
      const pictures = this.pictures[back];
      for (const i of this.order) {
        if (!cells[i] || (faded?.[i] || absent?.[i] || 0) !== back) continue;
        const key = (shades[i] * FORMS.length + forms[i]) * SHARES.length + levels[cells[i]];
        const one = pictures[key] ??= this.pictureOf(shades[i], forms[i], levels[cells[i]], radius, back);
        stamp(this.image, one, Math.round(x0 + scale * (x[i] - centre[0]) - one.width / 2),
          Math.round(y0 - scale * (y[i] - centre[1]) - one.width / 2));
      }
    }
    return this.image;
  }

  /** The picture of a point, so large that it can be drawn at whole pixels. */
  pictureOf(shade, form, level, full, back) {
    const [size, opacity] = SHARES[level];
    const radius = size * full;
    const side = 2 * Math.ceil(1.5 * radius + 1) + 1; // odd, for a round point
    const made = Object.assign(document.createElement("canvas"), { width: side, height: side });
    const context = made.getContext("2d");
    const colour = this.palette[shade];
    context.globalAlpha = opacity;
    context.fillStyle = back ? `color-mix(in srgb, ${colour} ${PALE}, ${colours.paper})` : colour;
    fillForm(context, form, side / 2, side / 2, radius);
    return context.getImageData(0, 0, side, side);
  }

  /**
   * How crowded each cell of the plane is at this zoom, as a place in SHARES, and in `cells` that of each point. Cells
   * stay as one moves, and each takes its neighbours into account, so that no cell is seen.
   */
  crowding() {
    const { x, y, count, width, height, absent, cells } = this;
    const perCell = this.scale / CELL; // cells in a unit of the points
    const [left, low] = this.placeOf(0, height).map((value) => Math.floor(value * perCell) - 2);
    const [columns, rows] = [width, height].map((length) => Math.ceil(length / CELL) + 5); // with an edge
    const counts = new Float32Array(columns * rows);
    for (let i = 0; i < count; i++) {
      const column = Math.floor(x[i] * perCell) - left;
      const row = Math.floor(y[i] * perCell) - low;
      cells[i] = column > 0 && row > 0 && column < columns && row < rows ? row * columns + column : 0;
      if (!absent?.[i]) counts[cells[i]]++;
    }
    counts[0] = 0; // those that are not seen
    const around = smooth(smooth(counts, 1), columns); // 1, 2, 1 of 4 along both axes
    const covers = (Math.PI * this.radius ** 2) / CELL ** 2; // of a cell, by a point
    return around.map((some) => {
      const crowd = (covers * (some - OWN)) / THIN;
      return crowd > 0 ? Math.min(SHARES.length - 1, Math.round(LEVELS_OF_TWO * Math.log2(1 + crowd))) : 0;
    });
  }
}

/** Draw a picture over a part of an image: ten thousand of them sooner than `drawImage` does. */
function stamp({ data, width, height }, { data: from, width: side }, left, top) {
  const [endRow, end] = [Math.min(side, height - top), Math.min(side, width - left)];
  for (let row = Math.max(0, -top); row < endRow; row++) {
    for (let column = Math.max(0, -left); column < end; column++) {
      const at = 4 * ((top + row) * width + left + column);
      const of = 4 * (row * side + column);
      const opacity = from[of + 3];
      if (!opacity) continue;
      const both = opacity + data[at + 3] * (1 - opacity / 255);
      const share = opacity / both;
      for (let c = 0; c < 3; c++) data[at + c] += share * (from[of + c] - data[at + c]);
      data[at + 3] = both;
    }
  }
}

function smooth(values, stride) {
  const made = new Float32Array(values.length);
  for (let i = stride; i < values.length - stride; i++) {
    made[i] = 0.25 * (values[i - stride] + 2 * values[i] + values[i + stride]);
  }
  return made;
}

/** The numbers below n in an order in which no group of points covers another one: multiples of a large prime. */
function mixed(n) {
  const stride = n % 7919 ? 7919 : 7907;
  const order = new Uint32Array(n);
  for (let i = 1; i < n; i++) order[i] = (order[i - 1] + stride) % n;
  return order;
}

function contains(corners, x, y) {
  let inside = false;
  for (let i = 0, j = corners.length - 1; i < corners.length; j = i++) {
    const [[x1, y1], [x2, y2]] = [corners[i], corners[j]];
    if (y1 > y !== y2 > y && x < x1 + ((x2 - x1) * (y - y1)) / (y2 - y1)) inside = !inside;
  }
  return inside;
}
