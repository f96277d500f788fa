// The player of motions: time, controls, and the name of the joint under the pointer.

// Controls of the picture, and all whose values are in a link.
const CONTROLS = [
  "place", "layout", "joint", "apart", "ground", "axes", "trails", "ghosts", "follow", "differences",
];
const LINKED = [...CONTROLS, "align", "speed"];

const clips = await Promise.all(data.motions.map(Clip.of));
const pairs = data.alignment && (await Pairs.of(data.alignment));
const clock = new Clock(clips, pairs);
const stage = new Stage(element("canvas"), clips, clock, {});
const state = { position: 0, playing: false };
const value = (id) => (element(id).type === "checkbox" ? element(id).checked : element(id).value);
const calm = matchMedia("(prefers-reduced-motion: reduce)");
let [loop, link, usual] = []; // the part that is played, the address, and values of controls as they are at first

// --- time ------------------------------------------------------------------------------------------------------------

/** What is seen: a tick, or between two; the last one before the loop begins again stays. */
function moment() {
  const { position, playing } = state;
  return playing && position > loop.to && position < loop.to + 1 ? loop.to : Math.min(position, clock.count - 1);
}

const tick = () => Math.floor(moment() + 1e-6);

function seek(position) {
  state.position = Math.max(0, Math.min(clock.count - 1, position));
  refresh();
}

function play(on) {
  if (!on) state.position = moment();
  state.playing = on && clock.count > 1;
  element("play").textContent = state.playing ? "Pause" : "Play";
  refresh();
}

function stop(position) {
  play(false);
  seek(position);
}

const refresh = animate(state, (seconds) => {
  state.position = loop.wrap(state.position + (seconds * Number(value("speed"))) / clock.seconds);
  return true;
}, () => {
  stage.draw(moment());
  writeTip();
  showTime();
  link.write();
});

function showTime() {
  const frames = clock.frames(tick()).map(Math.floor);
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
  for (const one of document.querySelectorAll(".overlaid")) one.hidden = !stage.overlaid;
  if (["place", "layout"].includes(event?.target.id)) reset();
  if (["follow", "apart"].includes(event?.target.id)) stage.fit(false);
  refresh();
}

function reset() {
  stage.fit(true);
  state.home = cameraWord(stage.camera);
  refresh();
}

/** Play the frames of two motions that belong together, or each in its own time; the loop is at the same shares. */
function align() {
  const share = (position) => position / Math.max(clock.count - 1, 1);
  const [position, from, to] = [state.position, loop.from, loop.to].map(share);
  clock.aligned = Boolean(pairs) && value("align");
  element("differences").disabled = !clock.aligned;
  Object.assign(loop, { from: 0, to: clock.count - 1 });
  loop.set("from", from * (clock.count - 1));
  loop.set("to", to * (clock.count - 1));
  seek(position * (clock.count - 1));
}

const keys = {
  " ": () => play(!state.playing),
  ",": () => stop(Math.ceil(state.position - 1e-6) - 1),
  ".": () => stop(tick() + 1),
  Home: () => stop(0),
  End: () => stop(Infinity),
  i: () => (loop.set("from", tick()), refresh()),
  o: () => (loop.set("to", tick()), refresh()),
  l: () => (loop.clear(), refresh()),
};

function listen() {
  followTheme(element("theme"), refresh);
  orbit(stage.canvas, stage.camera, {
    moved: refresh,
    point: (x, y, touch) => (stage.point(x, y, touch ? 28 : 14), refresh()),
    leave: () => ((stage.hover = null), refresh()),
    home: reset,
    keys,
  });
  document.addEventListener("keydown", (event) => { // where nothing has the focus
    const { target, key, ctrlKey, altKey, metaKey } = event;
    if (target !== document.body || ctrlKey || altKey || metaKey || key !== " ") return;
    keys[" "]();
    event.preventDefault();
  });
  element("play").addEventListener("click", () => play(!state.playing));
  element("time").addEventListener("input", () => stop(Number(value("time"))));
  element("home").addEventListener("click", reset);
  for (const id of CONTROLS) element(id).addEventListener("change", choose);
  element("align").addEventListener("change", align);
  element("speed").addEventListener("change", refresh);
  listenForDialog("help", "about", "close");
  listenForDialog("share", "sharing", "done");
  listenForFiles(stage, { now: moment, loop: loopOfFile, begin: () => play(false) });
  new ResizeObserver(() => (stage.fit(false), refresh())).observe(stage.canvas);
}

/** The loop as a video has it: its duration, s, and what is seen at so many seconds. */
function loopOfFile() {
  const [{ from, to }, ticks] = [loop, Number(value("speed")) / clock.seconds]; // a second
  return { duration: (to + 1 - from) / ticks, moment: (seconds) => Math.min(from + seconds * ticks, to) };
}

// --- the link --------------------------------------------------------------------------------------------------------

/** What is in a link. While it plays there is no time, and the link plays. */
function linked() {
  const seconds = (tick) => Number((tick * clock.seconds).toFixed(4));
  const camera = cameraWord(stage.camera);
  const wordOfControl = (of) => (typeof of === "boolean" ? String(Number(of)) : of);
  const words = LINKED.map((id) => [id, value(id) === usual[id] ? null : wordOfControl(value(id))]);
  return {
    t: state.playing ? null : seconds(state.position),
    loop: loop.isWhole ? null : `${seconds(loop.from)},${seconds(loop.to)}`,
    camera: camera === state.home ? null : camera,
    finding: typeof chosen === "string" && location.hash ? chosen : null, // of findings.js
    ...Object.fromEntries(words),
  };
}

/** Show what a link says; what it does not say, or says wrongly, is as usual. */
function restore(words) {
  for (const id of LINKED) setControl(element(id), words.get(id), usual[id]);
  choose();
  align();
  reset();
  restoreCamera(stage.camera, words.get("camera"));
  const ticks = (numbers) => numbers?.map((seconds) => seconds / clock.seconds);
  const [time, range] = [ticks(numbersIn(words.get("t"), 1)), ticks(numbersIn(words.get("loop"), 2))];
  loop.clear();
  if (range && range[0] <= range[1]) ["from", "to"].forEach((end, i) => loop.set(end, range[i]));
  if (!time) return play(!calm.matches);
  const [at, near] = [time[0], Math.round(time[0])];
  stop(Math.abs(at - near) < 0.01 ? near : at);
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
  Object.assign(element("apart"), { max: 2 * stage.size, step: cellOf(stage.size) });
  for (const one of document.querySelectorAll(".several")) one.hidden = clips.length < 2;
  for (const one of document.querySelectorAll(".aligned")) one.hidden = !pairs;
  for (const id of ["play", "time"]) element(id).disabled = clock.count < 2;
  element("most").textContent = pairs ? `${(100 * pairs.largest).toPrecision(3)} cm apart` : "";
  element("layout").value = data.overlay ? "overlay" : "side";
  const turns = clips.every((clip) => clip.headings); // it is not known where points face
  if (!turns) element("place").querySelector("[value=forward]").remove();
  element("place").value = !pairs && !data.overlay ? "world" : turns ? "forward" : "spot";
}

function writeTip() {
  const { hover, overlaid, canvas } = stage;
  const [tip, write] = [element("tip"), (place, words) => showTip(tip, canvas, place, words)];
  const figure = hover && stage.views.flatMap((view) => view.figures).find((one) => one.clip === hover.clip);
  const place = figure?.flat[hover.index];
  if (!place) return write({}, null);
  const [joint, clip] = [hover.index - 1, clips[hover.clip]];
  const words = [textElement("span", joint < 0 ? "root" : clip.names[joint])];
  if (overlaid) words.push(" of ", textElement("span", clip.label));
  if (clock.aligned && joint >= 0) {
    words.push(`: ${(100 * pairs.distance(tick(), hover.clip, joint)).toFixed(1)} cm apart`);
  }
  write(place, words);
}

describe();
usual = Object.fromEntries(LINKED.map((id) => [id, value(id)]));
loop = new Loop(clock, refresh);
link = new Link(linked, restore);
listen();
restore(link.words);
window.skpose = { state, stage, clock, tick, moment, loop, link }; // for tests, and for the console of the browser
