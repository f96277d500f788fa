// Skeletons, ground and axes in a canvas, as a camera sees them. y points up; lengths are m, angles rad.

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
    return { rectangle, target, distance, seen, near: NEAR * distance, project: (point) => flat(seen(point)), flat };
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

/** Draw a line between two points in space, without the part behind the camera. */
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

/**
 * How thick bones are, m, by their lengths. A short one that joins others, such as the links of a robot's hip, is not
 * thinner than those on both sides; one of no length, but for rounding, is as the one before it.
 */
function widthsOf(lengths, parents, size) {
  const [thickest, shortest] = [0.022 * size, 1e-3 * size];
  const own = lengths.map((length) => (length > shortest ? Math.min(thickest, 0.22 * length + 0.004 * size) : 0));
  /** The bone before one, without those of no length; -1 at the root. */
  const beforeOf = (joint) => {
    do joint = parents[joint]; while (joint >= 0 && !own[joint]);
    return joint;
  };
  const after = new Map(); // the thickest of those that begin at its end
  own.forEach((width, joint) => {
    if (width) after.set(beforeOf(joint), Math.max(width, after.get(beforeOf(joint)) ?? 0));
  });
  return own.map((width, joint) => {
    const before = own[beforeOf(joint)] ?? after.get(-1) ?? thickest;
    return width ? Math.max(width, Math.min(before, after.get(joint) ?? 0)) : before;
  });
}

/**
 * Draw a skeleton, far parts first; return its points as projected, null where they are not drawn.
 *
 * `points` are root and joints; `parents` the index of each joint's parent among the joints, -1 for the root;
 * `colourOf` and `widthOf` (a factor) take the index of a joint; `shadow` is whether it has one on the ground; `shows`
 * whether a point is drawn, by its index among the points.
 */
function drawFigure(context, view, points, parents, options) {
  const { size, colourOf, rootColour, widthOf = () => 1, shadow, shows = () => true } = options;
  const flat = points.map(view.project);
  const lengths = parents.map((parent, joint) => {
    const [a, b] = [points[parent + 1], points[joint + 1]];
    return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  });
  const widths = widthsOf(lengths, parents, size);
  const bones = parents.map((parent, joint) => {
    const [from, to, length] = [flat[parent + 1], flat[joint + 1], lengths[joint]];
    const thick = widths[joint] * ((from.scale + to.scale) / 2);
    return { joint, from, to, length, away: (from.away + to.away) / 2, width: Math.max(thick, 1.5) * widthOf(joint) };
  });
  const drawn = bones.filter(({ joint, length, from, to }) => length > 0 && Math.min(from.away, to.away) > view.near
    && shows(joint + 1) && shows(parents[joint] + 1));
  context.lineCap = context.lineJoin = "round";
  if (shadow) {
    context.strokeStyle = colours.shadow;
    context.lineWidth = Math.max(1, 0.02 * size * flat[0].scale);
    context.beginPath();
    for (const { joint } of drawn) {
      segment(context, view, ...[parents[joint] + 1, joint + 1].map((i) => [points[i][0], 0, points[i][2]]));
    }
    parents.forEach((parent, joint) => { // points without a bone, as a line of nearly no length
      const [x, , z] = points[joint + 1];
      if (shows(joint + 1) && !shows(parent + 1)) segment(context, view, [x, 0, z], [x + 0.003 * size, 0, z]);
    });
    context.stroke();
  }
  const dots = flat.map((at, i) => {
    const thick = (bones[i - 1] ?? bones.find((bone) => bone.length > 0))?.width ?? 8;
    const radius = Math.max(Math.min(0.55 * thick, 0.02 * size * at.scale), 1.6);
    return { at, radius, away: at.away - 0.03 * size, colour: i ? colourOf(i - 1) : rootColour };
  }).filter((dot, i) => dot.away > view.near && shows(i));
  for (const part of [...drawn, ...dots].sort((a, b) => b.away - a.away)) {
    context.beginPath();
    if (part.at) {
      context.arc(part.at.x, part.at.y, part.radius, 0, 2 * Math.PI);
      context.fillStyle = part.colour;
      context.fill();
      continue;
    }
    context.moveTo(part.from.x, part.from.y);
    context.lineTo(part.to.x, part.to.y);
    context.strokeStyle = colours.paper; // an edge that sets a bone apart from those behind it
    context.lineWidth = part.width + Math.min(2.5, 0.6 + 0.25 * part.width);
    context.stroke();
    context.strokeStyle = colourOf(part.joint);
    context.lineWidth = part.width;
    context.stroke();
  }
  return flat.map((at, i) => (shows(i) ? at : null));
}

/** Write which colours left and right have, up to a place. */
function drawSides(context, x, y) {
  Object.assign(context, { font: FONT, textBaseline: "alphabetic", textAlign: "right" });
  for (const [side, at] of [["right", x], ["left", x - 38]]) {
    context.fillStyle = colours[side];
    context.fillText(side, at, y);
  }
}

/** Mark a projected point with a ring. */
function drawRing(context, { x, y }) {
  context.beginPath();
  context.arc(x, y, 8, 0, 2 * Math.PI);
  context.strokeStyle = colours.ink;
  context.lineWidth = 2;
  context.stroke();
}

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
