// A camera, and the ground and axes as it sees them in a canvas. y points up; lengths are m, angles rad.

const NEAR = 0.02; // nothing nearer than this share of the camera's distance is drawn
const FONT = "13px system-ui, sans-serif";
const FIELD = Math.tan((15 * Math.PI) / 180); // half of what is seen, at distance one

/** A camera that looks at a target from a direction, and is moved by `turn`, `zoomBy` and `pan`. */
class Camera {
  azimuth = 0;
  elevation = 0.2;
  distance = 4; // at zoom 1
  zoom = 1;
  shift = [0, 0]; // to the right and up, in shares of the distance

  turn(right, up) {
    this.azimuth -= right;
    this.elevation = Math.max(-1.55, Math.min(1.55, this.elevation + up));
  }

  zoomBy(factor) {
    this.zoom = Math.max(0.05, Math.min(50, this.zoom * factor));
  }

  pan(right, up) {
    this.shift = [this.shift[0] + right / this.zoom, this.shift[1] + up / this.zoom];
  }

  /** The view of a target in a rectangle of the canvas, px. */
  view(rectangle, target) {
    const [sinA, cosA] = [Math.sin(this.azimuth), Math.cos(this.azimuth)];
    const [sinE, cosE] = [Math.sin(this.elevation), Math.cos(this.elevation)];
    const distance = this.distance / this.zoom;
    const focal = Math.min(rectangle.width, rectangle.height) / (2 * FIELD);
    const [x0, y0] = [rectangle.x + rectangle.width / 2, rectangle.y + rectangle.height / 2];
    const [moveX, moveY] = this.shift.map((share) => share * this.distance);
    /** Coordinates to the right, up, and away from the camera. */
    const seen = ([x, y, z]) => {
      const [dx, dy, dz] = [x - target[0], y - target[1], z - target[2]];
      return [
        cosA * dx - sinA * dz - moveX,
        -sinE * (sinA * dx + cosA * dz) + cosE * dy - moveY,
        distance - cosE * (sinA * dx + cosA * dz) - sinE * dy,
      ];
    };
    const flat = ([right, up, away]) => {
      const scale = focal / Math.max(away, NEAR * distance);
      return { x: x0 + scale * right, y: y0 - scale * up, away, scale };
    };
    const project = (point) => flat(seen(point));
    return { rectangle, target, distance, seen, near: NEAR * distance, project, flat, squash: sinE };
  }

  /** The distance at which all points, relative to the target, are seen in a rectangle, but for its upper edge. */
  distanceTo(points, { width, height }, edge = 0) {
    const side = Math.min(width, height);
    const { seen } = Object.assign(new Camera(), this, { distance: 1, zoom: 1, shift: [0, 0] })
      .view({ x: 0, y: 0, width, height }, [0, 0, 0]);
    let least = 0;
    for (const point of points) {
      const [right, up, away] = seen(point);
      const share = Math.max((Math.abs(right) * side) / width, (Math.abs(up) * side) / (height - 2 * edge));
      least = Math.max(least, 1 - away + share / (0.86 * FIELD));
    }
    return least || 1;
  }
}

/** Give a canvas the pixels of the display, empty, to be drawn in px. */
function sharpen(canvas, context) {
  const density = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((length) => Math.round(length * density));
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  context.setTransform(density, 0, 0, density, 0, 0);
  context.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
}

function segment(context, view, a, b) {
  let [p, q] = [view.seen(a), view.seen(b)];
  if (p[2] > q[2]) [p, q] = [q, p];
  if (q[2] <= view.near) return;
  if (p[2] < view.near) {
    const share = (view.near - p[2]) / (q[2] - p[2]);
    p = p.map((value, i) => value + share * (q[i] - value));
  }
  const [from, to] = [view.flat(p), view.flat(q)];
  context.moveTo(from.x, from.y);
  context.lineTo(to.x, to.y);
}

/** The length 1, 2 or 5 times a power of ten that is next below a third of a size. */
function cellOf(size) {
  const power = 10 ** Math.floor(Math.log10(size / 3));
  return power * [5, 2, 1].find((digit) => digit * power <= (size / 3) * (1 + 1e-9));
}

/** Draw the ground, y = 0, as a grid around the target that fades out. */
function drawGround(context, view, cell, reach = 14) {
  const { x, y, scale } = view.project([view.target[0], 0, view.target[2]]);
  const radius = Math.max(0.5 * reach * cell * scale, 1);
  const fade = context.createRadialGradient(x, y, 0, x, y, radius);
  fade.addColorStop(0, colours.grid);
  fade.addColorStop(1, `${colours.grid}00`);
  context.strokeStyle = fade;
  context.lineWidth = 1;
  context.beginPath();
  const [atX, atZ] = [view.target[0], view.target[2]].map((value) => Math.round(value / cell) * cell);
  for (let i = -reach; i <= reach; i++) {
    segment(context, view, [atX + i * cell, 0, atZ - reach * cell], [atX + i * cell, 0, atZ + reach * cell]);
    segment(context, view, [atX - reach * cell, 0, atZ + i * cell], [atX + reach * cell, 0, atZ + i * cell]);
  }
  context.stroke();
}

/** Draw the directions of the three axes in the lower left corner, with the names that they have in the file. */
function drawAxes(context, view, names) {
  const { x, y, height } = view.rectangle;
  const [middle, base] = [x + 40, y + height - 40];
  const origin = view.seen(view.target);
  const ends = [0, 1, 2].map((axis) => {
    const end = view.seen(view.target.map((value, i) => value + (i === axis ? 1 : 0)));
    return { name: names[axis], at: end.map((value, i) => value - origin[i]) };
  });
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  for (const { name, at } of ends.filter((end) => end.name).sort((a, b) => b.at[2] - a.at[2])) {
    context.strokeStyle = context.fillStyle = colours[`axis-${name}`];
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(middle, base);
    context.lineTo(middle + 22 * at[0], base - 22 * at[1]);
    context.stroke();
    context.fillText(name, middle + 31 * at[0], base - 31 * at[1]);
  }
}

function drawSides(context, x, y) {
  Object.assign(context, { font: FONT, textBaseline: "alphabetic", textAlign: "right" });
  for (const [side, at] of [["right", x], ["left", x - 38]]) {
    context.fillStyle = colours[side];
    context.fillText(side, at, y);
  }
}

function drawRing(context, { x, y }) {
  context.beginPath();
  context.arc(x, y, 8, 0, 2 * Math.PI);
  context.strokeStyle = colours.ink;
  context.lineWidth = 2;
  context.stroke();
}

const centreOfBox = (points) => [0, 1, 2].map((axis) => {
  const [low, high] = points.reduce(([a, b], point) => [Math.min(a, point[axis]), Math.max(b, point[axis])],
    [Infinity, -Infinity]);
  return (low + high) / 2;
});

/** The index of the projected point that is nearest to a place in the canvas, of those within a distance, or -1. */
function nearestPoint(flat, x, y, within) {
  let [best, least] = [-1, within];
  flat.forEach((point, i) => {
    if (!point) return;
    const far = Math.hypot(point.x - x, point.y - y);
    if (far < least) [best, least] = [i, far];
  });
  return best;
}

/** The direction (azimuth) that root and joints face where left and right are known and so far apart, or null. */
function facing(points, sides, least) {
  const across = [0, 0]; // from right to left
  points.slice(1).forEach(([x, , z], joint) => {
    const sign = { left: 1, right: -1 }[sides[joint]] ?? 0;
    across[0] += sign * x;
    across[1] += sign * z;
  });
  return Math.hypot(...across) > least ? Math.atan2(-across[1], across[0]) : null;
}
