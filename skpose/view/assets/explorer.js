// The explorer of poses: what is chosen, time, controls, and the texts about it.

const PARTS = 60; // steps of the slider along the line between two poses
const SECONDS = 2; // of that line
const N_COLOURS = 10; // of groups; the eleventh has the colour of the first, and another form

const poses = await Poses.of(data);
const tables = await Promise.all(data.embeddings.map((embedding) => unpack(embedding.points)));
const scatter = new Scatter(element("layer"), element("canvas"), poses.count);
const view = new PoseView(element("figure"), poses);
const marks = element("canvas").getContext("2d");
const small = new SmallFigures(poses, view, data.size);
const sheet = new Sheet(scatter, view, (context, moment) =>
  drawMarks(context, scatter, poses, moment, () => drawSmall(context, true)), keyOf);
const calm = matchMedia("(prefers-reduced-motion: reduce)");
const state = {
  hover: -1, // the point under the pointer, or that the arrow keys have reached
  clicked: -1, // the point under the pointer that was clicked, until the pointer has left it
  first: -1, // the pose that was chosen
  current: 0, // the pose that is shown
  comparison: null,
  share: 0, // of the line between its poses
  lasso: [], // corners, in the plane
  inside: null, // the poses in the lasso
  group: -1, // that is seen alone
  time: 0, // s since the first pose of the motion
  playing: false,
  moved: true, // whether the points have moved or changed since they were drawn
};
const mode = () => document.querySelector("input[name=mode]:checked").value;

// --- time ------------------------------------------------------------------------------------------------------------

const ask = animate(state, pass, () => {
  if (state.moved) scatter.draw();
  state.moved = false;
  sharpen(scatter.canvas, marks);
  drawMarks(marks, scatter, poses, state, drawSmall);
  view.draw(state);
  if (small.late) refresh();
  write();
  link.write();
});

/** Draw again; the points only where they have moved or changed. */
function refresh(moved = false) {
  state.moved ||= moved;
  ask();
}

function play(on) {
  state.playing = on;
  if (on) state.hover = -1; // what plays is seen
  element("play").textContent = on ? "Pause" : "Play";
  refresh();
}

function show(row) {
  Object.assign(state, { current: row, time: poses.time(row) });
  refresh();
}

/** Let time pass, from the end back to the start; return whether another pose is shown. */
function pass(seconds) {
  if (state.comparison) {
    state.share = (state.share + seconds / SECONDS) % 1;
    return true;
  }
  const [range, before] = [poses.range(state.current), state.current];
  state.time += seconds;
  if (state.time > poses.duration(range)) state.time = 0;
  state.current = poses.rowAt(range, state.time);
  return state.current !== before;
}

function seek(at) {
  play(false);
  state.hover = -1;
  const { first, end } = poses.range(state.current);
  if (state.comparison) state.share = Math.max(0, Math.min(PARTS, at)) / PARTS;
  else show(Math.max(first, Math.min(end - 1, first + at)));
}

const position = () =>
  state.comparison ? Math.round(PARTS * state.share) : state.current - poses.range(state.current).first;

// --- choices ---------------------------------------------------------------------------------------------------------

/** Choose a pose and play from there, or with `second` compare it with the one that was chosen before. */
function choose(row, second) {
  state.hover = -1;
  if (second && state.first >= 0) {
    Object.assign(state, { comparison: new Comparison(poses, state.first, row), share: 0 });
    show(row);
  } else {
    Object.assign(state, { first: row, comparison: null });
    show(row);
  }
  play(!calm.matches);
  announce();
  writeComparison();
}

function endComparison() {
  if (!state.comparison) return;
  state.comparison = null;
  writeComparison();
  refresh();
}

/** Enclose points; without corners release them. */
function enclose(corners) {
  state.lasso = corners;
  state.inside = corners.length > 2 ? scatter.inside(corners) : null;
  writeInside();
  fade();
}

function fade() {
  const { inside, group } = state;
  const groups = poses.groups(element("colour").value);
  const chosen = inside?.length ? new Set(inside) : null;
  scatter.faded = chosen && Uint8Array.from(groups.of, (of, row) => Number(!chosen.has(row)));
  scatter.absent = group < 0 ? null : Uint8Array.from(groups.of, (of) => Number(of !== group));
  refresh(true);
}

const embedding = () => data.embeddings.findIndex(({ metric, method }) =>
  metric === element("metric").value && method === element("method").value);

function choosePlane() {
  const i = embedding();
  scatter.place(tables[i]);
  state.lasso = []; // its corners are places of another plane; what was inside stays chosen
  state.hover = -1;
  const { metric, method, share, unit } = data.embeddings[i];
  state.unit = unit; // none where lengths in the plane mean nothing
  const variance = share === null ? "" : `, ${(100 * share).toFixed(0)} % of the variance`;
  element("canvas").setAttribute("aria-label", `Poses as points in the plane; metric ${metric}, ${method}${variance}`);
  refresh(true);
}

function drawSmall(context, all) {
  state.figures = !element("figures").checked ? [] : small.draw(context, scatter, {
    all,
    colourOf: (row) => state.colourOf(row),
    hidden: (row) => scatter.absent?.[row] || scatter.faded?.[row],
  });
}

function colour() {
  const groups = poses.groups(element("colour").value);
  const { names, of } = groups;
  scatter.palette = names ? Array.from({ length: N_COLOURS }, (_, i) => groupColour(i))
    : Array.from({ length: 65 }, (_, i) => heat(i / 64));
  for (let row = 0; row < poses.count; row++) {
    scatter.colours[row] = names ? of[row] % N_COLOURS : Math.round(64 * of[row]);
    scatter.forms[row] = names ? formOf(of[row]) : 0;
  }
  state.colourOf = (row) => (names ? groupColour(of[row]) : heat(of[row]));
  small.group(scatter, groups);
  for (const swatch of document.querySelectorAll(".swatch")) {
    swatch.style.background = groupColour(swatch.group);
    swatch.dataset.form = formOf(swatch.group);
  }
  refresh(true);
}

const formOf = (i) => Math.floor(i / N_COLOURS) % FORMS.length;
const groupColour = (i) => colours[i % N_COLOURS < 5 ? `motion-${i % N_COLOURS}` : `group-${i % N_COLOURS}`];

// --- pointer and keys ------------------------------------------------------------------------------------------------

const within = () => (matchMedia("(pointer: coarse)").matches ? 24 : 14); // px

function hover(row) {
  if (row === state.hover) return;
  state.hover = row;
  refresh();
}

/** Do with a pose what a click does; with Shift it is the second of two. */
function click(row, shift) {
  if (row >= 0) choose(row, shift || mode() === "compare");
}

function go(right, up) {
  const from = state.hover >= 0 ? state.hover : state.current;
  const row = scatter.next(from, right, up);
  scatter.show(row);
  state.hover = row;
  announce();
  refresh(true);
}

function enter(shift) {
  const row = state.hover >= 0 ? state.hover : state.current;
  if (mode() !== "lasso") return click(row, shift);
  enclose([...state.lasso, [scatter.x[row], scatter.y[row]]]);
  announce();
}

function escape() {
  if (state.lasso.length || state.inside) enclose([]);
  else endComparison();
  hover(-1);
}

function listen() {
  const home = () => (scatter.home(), view.fit(true), refresh(true));
  followTheme(element("theme"), colour);
  moveScatter(element("canvas"), scatter, {
    moved: () => refresh(true),
    point: (x, y) => {
      const row = scatter.nearest(x, y, within());
      if (row !== state.clicked) state.clicked = -1;
      hover(state.clicked < 0 ? row : -1); // what was clicked plays on under the pointer
    },
    leave: () => hover(-1),
    click: (x, y, { shiftKey }) => ((state.clicked = scatter.nearest(x, y, within())), click(state.clicked, shiftKey)),
    lassoes: () => mode() === "lasso",
    lasso: (corners) => (hover(-1), enclose(corners)),
    go,
    keys: {
      Enter: enter,
      Escape: escape,
      " ": () => play(!state.playing),
      ",": () => seek(position() - 1),
      ".": () => seek(position() + 1),
      Home: () => seek(0),
      End: () => seek(Infinity),
      0: home,
    },
  });
  orbit(view.canvas, view.camera, {
    moved: () => refresh(), point: () => {}, leave: () => {}, home: () => (view.fit(true), refresh()), keys: {},
  });
  element("play").addEventListener("click", () => play(!state.playing));
  element("time").addEventListener("input", () => seek(Number(element("time").value)));
  element("home").addEventListener("click", home);
  element("figures").addEventListener("change", () => refresh());
  for (const id of ["metric", "method"]) element(id).addEventListener("change", () => (choosePlane(), colour()));
  element("colour").addEventListener("change", () => ((state.group = -1), writeGroups(), colour(), fade()));
  const back = () => element("canvas").focus({ preventScroll: true }); // as the button is hidden
  element("end").addEventListener("click", () => (endComparison(), back()));
  element("release").addEventListener("click", () => (enclose([]), back()));
  listenForDialog("help", "about", "close");
  listenForDialog("share", "sharing", "done");
  listenForFiles(sheet, { now: () => ({ ...state }), loop: loopOfFile, begin: () => play(false) });
  const resized = new ResizeObserver(() => (view.fit(false), refresh(true)));
  for (const canvas of [element("canvas"), view.canvas]) resized.observe(canvas);
}

/** What a video shows: the motion, or the line between two poses; its duration, s, and the state at so many seconds. */
function loopOfFile() {
  if (state.comparison) {
    return { duration: SECONDS, moment: (at) => ({ ...state, hover: -1, share: Math.min(1, at / SECONDS) }) };
  }
  const range = poses.range(state.current);
  const duration = poses.duration(range) || 1;
  return { duration, moment: (at) => ({ ...state, hover: -1, current: poses.rowAt(range, at) }) };
}

describe();
const usual = Object.fromEntries(["colour", "metric", "method"].map((id) => [id, element(id).value])); // as at first
const link = new Link(linked, restore);
listen();
restore(link.words);
// For tests, and for the console of the browser.
window.skpose = { state, stage: scatter, view, poses, position, link, small, sheet };
