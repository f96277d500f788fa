// What every page of skpose.view needs: its data, colours for dark and light, text that stays text.

const element = (id) => document.getElementById(id);

const data = JSON.parse(element("data").textContent);

/**
 * Undo `pack` of skpose/view/_scene.py. The result's `at(row, column)` is a number.
 *
 * The bytes are those of differences from row to row, column by column, of all numbers first the low bytes.
 */
async function unpack({ shape: [rows, columns] = [], low, step, bytes, data: text, given }) {
  if (given) return { rows: given.length, at: (row, column) => step * given[row][column] }; // as they are
  const compressed = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const stream = new Blob([compressed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const content = new Uint8Array(await new Response(stream).arrayBuffer());
  const n = rows * columns;
  const whole = bytes === 2 ? new Uint16Array(n) : new Uint32Array(n);
  for (let i = 0; i < n; i++) {
    let change = 0;
    for (let b = bytes - 1; b >= 0; b--) change = change * 256 + content[b * n + i];
    whole[i] = change + (i % rows ? whole[i - 1] : 0); // the array takes it modulo its number of levels
  }
  return { rows, columns, at: (row, column) => low + step * whole[column * rows + row] };
}

/** Colours of the style sheet by name, as they are at present. */
const colours = new Proxy({}, {
  get: (read, name) => (read[name] ??= getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()),
});

function heat(share) {
  const [from, to] = share < 0.5 ? ["heat-0", "heat-1"] : ["heat-1", "heat-2"];
  const channel = (colour, at) => parseInt(colours[colour].slice(at, at + 2), 16);
  const part = share < 0.5 ? 2 * share : 2 * share - 1;
  const mixed = [1, 3, 5].map((at) => (1 - part) * channel(from, at) + part * channel(to, at));
  return `rgb(${mixed.map(Math.round).join(" ")})`;
}

const LONGEST = 0.25; // s between two frames of the display; a page that slept does not jump

/**
 * Return a function that asks for a new picture before the next frame of the display. While `state.playing`,
 * `pass(seconds)` lets time pass and returns whether the picture changes; `draw()` draws it.
 */
function animate(state, pass, draw) {
  Object.assign(state, { stale: false, drawn: 0 });
  let [before, waiting] = [null, false];
  const step = (now) => {
    if (state.playing && before !== null) state.stale = pass(Math.min((now - before) / 1000, LONGEST)) || state.stale;
    before = state.playing ? now : null;
    waiting = state.playing;
    if (waiting) requestAnimationFrame(step);
    if (!state.stale) return;
    state.stale = false;
    draw();
    if (!state.drawn++) performance.mark("skpose: first frame drawn");
  };
  return () => {
    state.stale = true;
    if (!waiting) requestAnimationFrame(step);
    waiting = true;
  };
}

/** The last of some rows, from `low` to `high`, whose time is not after a given one. */
function lastNotAfter(time, low, high, timeOf) {
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (timeOf(middle) <= time + 1e-6) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** Follow the system's choice of dark or light until the button is pressed; call `changed` after each change. */
function followTheme(button, changed) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const apply = (theme) => {
    document.documentElement.dataset.theme = theme;
    button.textContent = theme === "dark" ? "Light" : "Dark";
    button.setAttribute("aria-label", theme === "dark" ? "Light colours" : "Dark colours");
    for (const name of Object.keys(colours)) delete colours[name];
    changed();
  };
  const follow = () => apply(system.matches ? "dark" : "light");
  system.addEventListener("change", follow);
  button.addEventListener("click", () => {
    system.removeEventListener("change", follow);
    apply(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  });
  follow();
}

/** Let a button open a dialog, and another one close it: a form could not where a frame may not send forms. */
function listenForDialog(button, dialog, close) {
  element(button).addEventListener("click", () => element(dialog).showModal());
  element(close).addEventListener("click", () => element(dialog).close());
}

/** A new element that holds text, never markup; the direction of writing is that of the text. */
function textElement(tag, text, attributes = {}) {
  const made = Object.assign(document.createElement(tag), attributes);
  made.textContent = text;
  made.dir = "auto";
  return made;
}
