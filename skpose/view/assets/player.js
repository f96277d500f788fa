// The player of motions: time, controls, and the name of the joint under the pointer.

const LONGEST = 0.25; // s between two frames of the display; a page that slept does not jump
const CONTROLS = ["place", "layout", "joint", "ground", "axes", "trails", "ghosts", "follow", "differences"];

if (typeof DecompressionStream === "undefined") {
  element("failure").textContent = "This page needs a browser of 2023 or later.";
  element("failure").hidden = false;
  throw new Error("DecompressionStream is missing");
}
const clips = await Promise.all(data.motions.map(Clip.of));
const pairs = data.alignment && (await Pairs.of(data.alignment));
const clock = new Clock(clips, pairs);
const stage = new Stage(element("canvas"), clips, clock, {});
const state = { position: 0, playing: false, before: null, stale: false, waiting: false, drawn: 0 };
const tick = () => Math.floor(state.position + 1e-6);
const value = (id) => (element(id).type === "checkbox" ? element(id).checked : element(id).value);

// --- time ------------------------------------------------------------------------------------------------------------

/** Go to a tick, which may lie outside. */
function seek(position) {
  state.position = Math.max(0, Math.min(clock.count - 1, position));
  refresh();
}

function play(on) {
  state.playing = on && clock.count > 1;
  element("play").textContent = state.playing ? "Pause" : "Play";
  refresh();
}

/** Pause, and go to another tick. */
function stop(position) {
  play(false);
  seek(position);
}

/** Draw again before the next frame of the display. */
function refresh() {
  state.stale = true;
  if (!state.waiting) requestAnimationFrame(step);
  state.waiting = true;
}

function step(now) {
  if (state.playing && state.before !== null) {
    const was = tick();
    const passed = Math.min((now - state.before) / 1000, LONGEST) * Number(value("speed"));
    state.position = (state.position + passed / clock.seconds) % clock.count; // from the end back to the start
    state.stale ||= tick() !== was;
  }
  state.before = state.playing ? now : null;
  state.waiting = state.playing;
  if (state.playing) requestAnimationFrame(step);
  if (!state.stale) return;
  state.stale = false;
  stage.draw(tick());
  showTip();
  showTime();
  if (!state.drawn++) performance.mark("skpose: first frame drawn");
}

function showTime() {
  const frames = clock.frames(tick());
  const seconds = (i) => (clips[i].start + clips[i].time(frames[i])).toFixed(2);
  const longest = clips.findIndex((clip) => clip.duration === clock.duration);
  const time = element("time");
  if (Number(time.max) !== clock.count - 1) time.max = clock.count - 1;
  time.value = tick();
  time.setAttribute("aria-valuetext", clock.aligned
    ? `${seconds(0)} and ${seconds(1)} seconds, pair ${tick() + 1} of ${clock.count}`
    : `${seconds(longest)} seconds, frame ${frames[longest] + 1} of ${clips[longest].frames}`);
  element("clock").textContent = clock.aligned ? `${seconds(0)} s | ${seconds(1)} s` : `${seconds(longest)} s`;
}

// --- controls --------------------------------------------------------------------------------------------------------

/** Read the controls; where the picture is another one, see all of it. */
function choose(event) {
  for (const id of CONTROLS) stage.options[id] = value(id);
  element("follow").disabled = value("place") !== "world"; // the root stays in the middle
  if (["place", "layout"].includes(event?.target.id)) stage.fit(true);
  if (event?.target.id === "follow") stage.fit(false);
  refresh();
}

function align() {
  const share = state.position / Math.max(clock.count - 1, 1);
  clock.aligned = value("align");
  element("differences").disabled = !clock.aligned;
  seek(share * (clock.count - 1));
}

function listen() {
  const reset = () => (stage.fit(true), refresh());
  followTheme(element("theme"), refresh);
  orbit(stage.canvas, stage.camera, {
    moved: refresh,
    point: (x, y, touch) => (stage.point(x, y, touch ? 28 : 14), refresh()),
    leave: () => ((stage.hover = null), refresh()),
    home: reset,
    keys: {
      " ": () => play(!state.playing),
      ",": () => stop(tick() - 1),
      ".": () => stop(tick() + 1),
      Home: () => stop(0),
      End: () => stop(Infinity),
    },
  });
  element("play").addEventListener("click", () => play(!state.playing));
  element("time").addEventListener("input", () => stop(Number(value("time"))));
  element("home").addEventListener("click", reset);
  for (const id of CONTROLS) element(id).addEventListener("change", choose);
  element("align").addEventListener("change", align);
  listenForHelp();
  new ResizeObserver(() => (stage.fit(false), refresh())).observe(stage.canvas);
}

// --- texts -----------------------------------------------------------------------------------------------------------

/** Write what the page holds, and show the controls that it needs. */
function describe() {
  const count = (n, word) => `${n.toLocaleString("en")} ${word}${n === 1 ? "" : "s"}`;
  const facts = clips.map(({ frames, rate, names, kind }) =>
    `${count(frames, "frame")} at ${Number(rate.toPrecision(4))} Hz, ${count(names.length, kind)}`);
  element("title").append(textElement("span", data.title, { title: data.title }));
  element("summary").textContent = clips.length === 1 ? facts[0] : count(clips.length, "motion");
  for (const [i, { label, error, seen, layout, standing, kind }] of clips.entries()) {
    const fact = document.createElement("li");
    const within = `positions within ${error.toPrecision(2)} mm of the ${seen ? "recording" : "motion"}'s`;
    const still = standing ? `where the lowest ${kind} stands still, in ${count(standing, "frame")}` : "";
    const ground = `The ground is ${still || `at the lowest ${kind}`}.`;
    fact.append(textElement("span", label), `: ${facts[i]}; ${within}. ${ground}`);
    if (layout) fact.append(" Bones of the layout ", textElement("span", layout), ".");
    element("facts").append(fact);
  }
  const names = new Set(clips.flatMap((clip) => clip.names));
  element("joint").append(...[...names].map((name) => textElement("option", name, { value: name })));
  for (const one of document.querySelectorAll(".several")) one.hidden = clips.length < 2;
  for (const one of document.querySelectorAll(".aligned")) one.hidden = !pairs;
  for (const id of ["play", "time"]) element(id).disabled = clock.count < 2;
  element("most").textContent = pairs ? `${(100 * pairs.largest).toPrecision(3)} cm apart` : "";
  element("layout").value = data.overlay ? "overlay" : "side";
  const turns = clips.every((clip) => clip.headings); // it is not known where points face
  if (!turns) element("place").querySelector("[value=forward]").remove();
  element("place").value = !pairs && !data.overlay ? "world" : turns ? "forward" : "spot";
}

/** Show the name of the joint under the pointer next to it. */
function showTip() {
  const [tip, { hover, canvas, overlaid }] = [element("tip"), stage];
  const figure = hover && stage.views.flatMap((view) => view.figures).find((one) => one.clip === hover.clip);
  tip.hidden = !figure?.flat[hover.index];
  if (tip.hidden) return;
  const [{ x, y }, joint, clip] = [figure.flat[hover.index], hover.index - 1, clips[hover.clip]];
  const words = [textElement("span", joint < 0 ? "root" : clip.names[joint])];
  if (overlaid) words.push(" of ", textElement("span", clip.label));
  if (clock.aligned && joint >= 0) {
    words.push(`: ${(100 * pairs.distance(tick(), hover.clip, joint)).toFixed(1)} cm apart`);
  }
  tip.replaceChildren(...words);
  const left = x + 14 + tip.offsetWidth > canvas.clientWidth ? x - 14 - tip.offsetWidth : x + 14;
  tip.style.left = `${Math.max(4, left)}px`;
  tip.style.top = `${Math.max(4, Math.min(y + 12, canvas.clientHeight - tip.offsetHeight - 4))}px`;
}

describe();
choose();
stage.fit(true);
listen();
play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
window.skpose = { state, stage, clock, tick }; // for tests, and for the console of the browser
