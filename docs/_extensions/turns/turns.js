// One angle at the shoulder and at the wrist of a person: two equal angles, two distances that are not.

const NEAR_HAND = 34; // px from the hand within which a drag turns it
const START = (60 * Math.PI) / 180;
const RISE = 1500; // ms of the movement that starts by itself
const ARC = 24; // points of the path of a joint

const skeleton = new Skeleton(data.skeleton);
const rest = new Float64Array(skeleton.width);
const slider = element("turn");
const most = (slider.max * Math.PI) / 180;
const posed = (column, angle) => rest.map((_, i) => (i === column ? angle : 0));

/** Root and joints, above the ground. */
function pointsOf(pose) {
  const at = skeleton.positions(pose);
  const joints = data.skeleton.names.map((_, j) => [at[3 * j], at[3 * j + 1] + data.height, at[3 * j + 2]]);
  return [[0, data.height, 0], ...joints];
}

/** A person who turns at one joint, and the two distances of that. */
class Turn {
  constructor(id, { name, column, hand }) {
    const figure = element(id);
    const [still, moved] = [0, 1].map((angle) => skeleton.positions(posed(column, angle)));
    Object.assign(this, { column, hand, canvas: figure.querySelector("canvas"), camera: new Camera() });
    this.context = this.canvas.getContext("2d");
    this.moves = data.skeleton.names.map((_, j) => [0, 1, 2].some((i) => still[3 * j + i] !== moved[3 * j + i]));
    this.pivot = data.skeleton.parents[this.moves.indexOf(true)] + 1; // a point that stays
    this.rows = Object.fromEntries(["angle", "spatial"].map((kind) => [kind, this.row(kind)]));
    const caption = figure.querySelector("figcaption");
    caption.append(textElement("h2", name), ...Object.values(this.rows).flatMap(Object.values));
    this.listen();
  }

  row(kind) {
    const track = Object.assign(document.createElement("span"), { className: `track ${kind}` });
    track.append(Object.assign(document.createElement("div"), { className: "bar" }));
    const [name, value] = [["span", kind], ["output", ""]].map((one) => textElement(...one, { className: kind }));
    return { name, track, value };
  }

  /** The distances between the person at rest and turned by an angle. */
  measure(angle) {
    return distances(skeleton, rest, posed(this.column, angle));
  }

  view() {
    const { canvas, camera } = this;
    Object.assign(camera, { azimuth: 0.4, elevation: 0.06 }); // from the side of the arm
    const around = data.around.map((point) => point.map((value, axis) => value - data.middle[axis]));
    camera.distance = camera.distanceTo(around, { width: canvas.clientWidth, height: canvas.clientHeight });
    return camera.view({ x: 0, y: 0, width: canvas.clientWidth, height: canvas.clientHeight }, data.middle);
  }

  draw(angle, largest) {
    const { context, column, moves } = this;
    const view = this.view();
    sharpen(this.canvas, context);
    drawGround(context, view, 0.25, 5);
    const { shape } = data.skeleton;
    const colourOf = (joint) => colours[moves[joint] ? "right" : "middle"];
    drawGhost(context, view, pointsOf(rest), shape, { colourOf, alpha: 0.25, shows: () => true });
    drawFigure(context, view, pointsOf(posed(column, angle)), shape, { size: data.size, colourOf, shadow: true });
    context.strokeStyle = colours.left;
    context.lineWidth = 2.5;
    const steps = Array.from({ length: ARC + 1 }, (_, i) => pointsOf(posed(column, (angle * i) / ARC)));
    context.beginPath();
    moves.forEach((moved, j) => moved && steps.forEach((points, i) => {
      const { x, y } = view.project(points[j + 1]);
      if (i) context.lineTo(x, y);
      else context.moveTo(x, y);
    }));
    context.stroke();
    this.at = view.project(steps.at(-1)[this.hand + 1]);
    this.around = view.project(steps[0][this.pivot]);
    drawRing(context, this.at);
    const found = this.measure(angle);
    for (const [kind, unit] of [["angle", "rad"], ["spatial", "m"]]) {
      this.rows[kind].track.firstChild.style.width = `${(100 * found[kind]) / largest[kind]}%`;
      this.rows[kind].value.textContent = `${found[kind].toFixed(2)} ${unit}`;
    }
    return found;
  }

  /** Let a drag of the hand turn the joint; a touch next to it scrolls the page. */
  listen() {
    const { canvas } = this;
    let held = null;
    const place = ({ clientX, clientY }) => {
      const { left, top } = canvas.getBoundingClientRect();
      return [clientX - left, clientY - top];
    };
    const isNear = (event) => Math.hypot(place(event)[0] - this.at.x, place(event)[1] - this.at.y) < NEAR_HAND;
    const keep = (event) => isNear(event.touches[0]) && event.preventDefault();
    canvas.addEventListener("touchstart", keep, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      if (event.pointerType === "touch" && !isNear(event)) return;
      held = this.direction(place(event)) - angle;
      canvas.setPointerCapture(event.pointerId);
    });
    const turn = (event) => held !== null && show(wrapped(this.direction(place(event)) - held));
    canvas.addEventListener("pointermove", turn);
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (held = null));
  }

  /** The direction from the joint that turns to a place in the picture, rad, from straight down. */
  direction([x, y]) {
    return Math.atan2(x - this.around.x, y - this.around.y);
  }
}

const turns = Object.entries(data.turns).map(([id, turn]) => new Turn(id, turn));
const largest = turns[0].measure(most);
let [angle, rising] = [0, true];

/** Show both turned by an angle. */
function show(wished) {
  angle = Math.max(0, Math.min(most, wished));
  rising = false;
  draw();
}

function draw() {
  const [first, second] = turns.map((turn) => turn.draw(angle, largest));
  slider.value = Math.round((180 * angle) / Math.PI);
  element("degrees").textContent = `${slider.value}°`;
  element("times").textContent = angle > 0 ? `${(first.spatial / second.spatial).toFixed(1)} times` : "more than";
}

/** Turn up to the angle of the start, once. */
function rise(start) {
  const step = (now) => {
    if (!rising) return;
    const share = Math.min(1, Math.max(0, (now - start) / RISE));
    angle = START * (1 - (1 - share) ** 3);
    draw();
    rising = share < 1;
    if (rising) requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

slider.addEventListener("input", () => show((slider.value * Math.PI) / 180));
new ResizeObserver(draw).observe(turns[0].canvas);
followTheme(element("theme"), draw);
if (matchMedia("(prefers-reduced-motion: reduce)").matches) show(START);
else rise(performance.now() + 400);
// For tests: places of the hands in their pictures, and whether the movement of the start is over.
window.shown = () => ({ hands: Object.fromEntries(Object.keys(data.turns).map((id, i) => [id, turns[i].at])), rising });
