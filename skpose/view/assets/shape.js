// Figures with volume: parts that are hulls of spheres about joints, see skpose/view/_shape.py.

const circle = (n) => Array.from({ length: n }, (_, i) => [Math.cos, Math.sin].map((f) => f((i * 2 * Math.PI) / n)));
const [ROUGH, ROUND, ROUNDEST] = [12, 20, 32].map(circle); // directions in which an outline is found
const LIGHT = [-0.64, -0.77]; // where it comes from, in the picture
// A soft shadow: how much wider than a sphere, up to which height, in sizes, where it is narrow, and how dark.
const SHADOWS = [[3, 1.3, 0.4], [1.8, 1, 0.5], [2.6, 0.16, 1], [1.7, 0.08, 1.5]];

const APART = 2.5; // px of the edge around a figure

const meanOf = (points, some) =>
  [0, 1, 2].map((axis) => some.reduce((sum, i) => sum + points[i][axis], 0) / some.length);
const lineOf = (points, [start, end]) => {
  const [a, b] = [meanOf(points, start), meanOf(points, end)];
  return b.map((value, axis) => value - a[axis]);
};
const unitOf = (vector) => {
  const length = Math.hypot(...vector);
  return length ? vector.map((value) => value / length) : vector;
};

/** The centre of a sphere: a mean of points, moved along a line, and at a right angle to it. */
function centreOf({ at, weights, along, across }, points) {
  if (at.length === 1 && !along) return points[at[0]];
  let centre = weights
    ? [0, 1, 2].map((axis) => at.reduce((sum, i, k) => sum + weights[k] * points[i][axis], 0))
    : meanOf(points, at);
  if (!along) return centre;
  const unit = unitOf(lineOf(points, along));
  centre = centre.map((value, axis) => value + along[2] * unit[axis]);
  if (!across) return centre;
  const line = lineOf(points, across);
  const share = line.reduce((sum, value, axis) => sum + value * unit[axis], 0);
  const side = unitOf(line.map((value, axis) => value - share * unit[axis]));
  return centre.map((value, axis) => value + across[2] * side[axis]);
}

/** The centres of a shape's spheres, null for those of which a point is not shown. */
function centresOf({ spheres }, points, shows) {
  return spheres.map((sphere) => {
    sphere.uses ??= [sphere.at, ...(sphere.along ?? []).slice(0, 2), ...(sphere.across ?? []).slice(0, 2)].flat();
    return sphere.uses.every(shows) ? centreOf(sphere, points) : null;
  });
}

function reachOf(shape, points, shows) {
  const ends = centresOf(shape, points, shows).flatMap((centre, i) => (centre
    ? [-1, 1].map((sign) => [centre[0], centre[1] + sign * shape.spheres[i].radius, centre[2]])
    : []));
  return [...points.filter((_, i) => shows(i)), ...ends];
}

/** The outline of the hull of discs, flattened to a share of their height: in each direction the farthest point. */
function outlineOf(discs, squash = 1, directions = ROUNDEST) {
  return directions.map(([cos, sin]) => {
    let [best, most] = [discs[0], -Infinity];
    for (const disc of discs) {
      const far = disc.x * cos + (disc.y / squash) * sin + disc.radius;
      if (far > most) [best, most] = [disc, far];
    }
    return { x: best.x + best.radius * cos, y: best.y + squash * best.radius * sin, disc: best };
  });
}

function trace(path, outline) {
  outline.forEach(({ x, y }, i) => (i ? path.lineTo(x, y) : path.moveTo(x, y)));
  path.closePath();
}

/** The discs of a hull that can be drawn: of a hull of three and more, two suffice. */
function discsOf(hull, discs) {
  const found = hull.map((i) => discs[i]).filter(Boolean);
  return found.length >= Math.min(2, hull.length) ? found : [];
}

const tones = new Map();

/** A colour, lighter by a share from 0 to 1, or darker by one from 0 to −1. */
function toneOf(colour, share) {
  const key = `${colour}${Math.round(32 * share)}`;
  if (!tones.has(key)) {
    const channels = colour[0] === "#"
      ? [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16))
      : colour.match(/\d+/g).map(Number);
    const [part, end] = [Math.abs(share), share > 0 ? 255 : 0];
    tones.set(key, `rgb(${channels.map((value) => Math.round(value + part * (end - value))).join(" ")})`);
  }
  return tones.get(key);
}

/** How a part is filled: darker towards its edges, lighter on the side of the light; its own colour in the middle. */
function fillOf(context, outline, discs, colour) {
  const [first, last] = [discs[0], discs.at(-1)];
  const [dx, dy] = [last.x - first.x, last.y - first.y];
  const length = Math.hypot(dx, dy);
  const round = length < Math.max(first.radius, last.radius);
  const [nx, ny] = round ? LIGHT : [-dy / length, dx / length];
  let [low, high] = [Infinity, -Infinity];
  for (const { x, y } of outline) {
    const far = x * nx + y * ny;
    low = Math.min(low, far);
    high = Math.max(high, far);
  }
  if (high - low < 5) return colour;
  const at = (far) => {
    const more = far - (first.x * nx + first.y * ny);
    return [first.x + more * nx, first.y + more * ny];
  };
  const lit = nx * LIGHT[0] + ny * LIGHT[1];
  const fill = context.createLinearGradient(...at(high), ...at(low));
  fill.addColorStop(0, toneOf(colour, 0.26 * lit - 0.08));
  fill.addColorStop(0.35, colour);
  fill.addColorStop(0.65, colour);
  fill.addColorStop(1, toneOf(colour, -0.26 * lit - 0.08));
  return fill;
}

/** Draw a soft shadow on the ground, without blurring: outlines over each other, each up to another height. */
function drawShadow(context, view, shape, centres, size) {
  if (view.squash <= 0) return;
  const feet = centres.map((centre) => centre && view.project([centre[0], 0, centre[2]]));
  context.fillStyle = colours.shadow;
  for (const [wider, reach, darkness] of SHADOWS) {
    context.globalAlpha = 0.8 * darkness;
    const discs = centres.map((centre, i) => {
      const share = centre && 1 - Math.max(0, centre[1]) / (reach * size);
      if (!(share > 0) || feet[i].away <= view.near) return null;
      return { ...feet[i], radius: wider * share * shape.spheres[i].radius * feet[i].scale };
    });
    context.beginPath();
    for (const [, hulls] of shape.parts) {
      for (const hull of hulls) {
        const found = hull.map((i) => discs[i]).filter(Boolean);
        if (found.length) trace(context, outlineOf(found, view.squash, ROUGH));
      }
    }
    context.fill();
  }
  context.globalAlpha = 1;
}

function flatten(view, shape, centres) {
  return centres.map((centre, i) => {
    const at = centre && view.project(centre);
    const { radius, inside } = shape.spheres[i];
    return at && at.away > view.near ? { ...at, radius: Math.max(radius * at.scale, 0.8), inside } : null;
  });
}

/**
 * Draw a figure, far parts first; return its points as projected, null where they are not drawn.
 *
 * `points` are root and joints; `shape` what they carry; `colourOf` takes the index of a joint, −1 for the root;
 * `shadow` is whether there is one on the ground; `apart` whether an edge sets all of it apart from what is behind;
 * `shows` whether a point is drawn, by its index among the points.
 */
function drawFigure(context, view, points, shape, { size, colourOf, shadow, apart, shows = () => true }) {
  const flat = points.map(view.project);
  const centres = centresOf(shape, points, shows);
  const discs = flatten(view, shape, centres);
  if (shadow) drawShadow(context, view, shape, centres, size);
  const parts = shape.parts.map(([joint, hulls]) => {
    const found = hulls.map((hull) => discsOf(hull, discs)).filter((some) => some.length);
    const all = found.flat();
    return { joint, found, all, away: all.reduce((sum, disc) => sum + disc.away, 0) / all.length };
  });
  context.lineJoin = "bevel";
  context.lineCap = "butt";
  context.strokeStyle = colours.paper; // an edge that sets a part apart from those behind it
  const seen = parts.filter((part) => part.all.length).sort((a, b) => b.away - a.away);
  for (const part of seen) {
    const widest = Math.max(...part.all.map((disc) => disc.radius));
    part.directions = widest < 5 ? ROUGH : widest < 25 ? ROUND : ROUNDEST;
    part.outlines = part.found.map((some) => outlineOf(some, 1, part.directions));
  }
  if (apart) {
    context.beginPath();
    for (const { outlines, directions } of seen) {
      for (const outline of outlines) {
        trace(context, outline.map(({ x, y }, i) => {
          const [cos, sin] = directions[i];
          return { x: x + APART * cos, y: y + APART * sin };
        }));
      }
    }
    context.fillStyle = colours.paper;
    context.fill();
  }
  for (const { joint, outlines, all } of seen) {
    context.beginPath();
    for (const outline of outlines) traceEdge(context, outline);
    context.lineWidth = Math.min(3, 0.8 + 0.15 * all[0].radius);
    context.stroke();
    context.beginPath();
    for (const outline of outlines) trace(context, outline);
    context.fillStyle = fillOf(context, outlines.flat(), all, colourOf(joint));
    context.fill();
  }
  return flat.map((at, i) => (shows(i) ? at : null));
}

/** Trace an outline, but not near the joints where another part goes on. */
function traceEdge(context, outline) {
  let joined = false; // whether the line before ends where this one starts
  outline.forEach((to, i) => {
    const from = outline.at(i - 1);
    const same = from.disc === to.disc;
    if (same && to.disc.inside) return (joined = false);
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    const gap = ({ disc }) => (disc.inside && !same ? Math.min(0.5, (1.2 * disc.radius) / Math.hypot(dx, dy)) : 0);
    const [first, last] = [gap(from), gap(to)];
    if (!joined || first) context.moveTo(from.x + first * dx, from.y + first * dy);
    context.lineTo(to.x - last * dx, to.y - last * dy);
    joined = !last;
  });
}

/** Draw the figure of another time as an even tint, one path for each colour. */
function drawGhost(context, view, points, shape, { colourOf, shows = () => true, alpha }) {
  const discs = flatten(view, shape, centresOf(shape, points, shows));
  const paths = new Map();
  for (const [joint, hulls] of shape.parts) {
    const colour = colourOf(joint);
    if (!paths.has(colour)) paths.set(colour, new Path2D());
    for (const some of hulls.map((hull) => discsOf(hull, discs)).filter((one) => one.length)) {
      trace(paths.get(colour), outlineOf(some, 1, ROUND));
    }
  }
  context.globalAlpha = alpha;
  for (const [colour, path] of paths) {
    context.fillStyle = colour;
    context.fill(path);
  }
  context.globalAlpha = 1;
}
