// Files that are dropped into the page: seen in the player, and compared by the distances. Nothing leaves the page.

const ESCAPED = { "<": "\\u003c", ">": "\\u003e", "&": "\\u0026" };
const MOST = 2; // files
const PAUSE = 40; // ms between two looks at the player's time
const [TALL, SMALL] = [5, 0.3]; // m, sizes that no person has

const state = { files: [], motions: [], shown: -1, values: null, problem: "" };
const value = (id) => element(id).value;

/** Read files, and show them; a problem is stated, and what was shown before stays. */
async function read(files) {
  const some = [...files].slice(0, MOST);
  if (!some.length) return;
  await stated(async () => {
    await show(await Promise.all(some.map(async (file) => {
      const label = file.name.replace(/\.bvh$/i, "");
      return { label, content: await named(file.name, async () => readBvh(await file.text())) };
    })));
    if (files.length > MOST) complain(`${files.length} files were given, and the first two are shown.`);
  });
}

function complain(words) {
  element("failure").textContent = words;
  element("failure").hidden = !words;
}

async function stated(work) {
  try {
    await work();
  } catch (error) {
    complain(error instanceof FileError ? error.message : `The files cannot be shown: ${error.message}.`);
  }
}

async function named(name, work) {
  try {
    return await work();
  } catch (error) {
    throw new FileError(`${name}: ${error instanceof FileError ? "" : "cannot be read: "}${error.message}.`);
  }
}

async function show(files) {
  const [unit, up] = [Number(value("unit")), value("up")];
  const shown = await Promise.all(files.map(({ label, content }) => named(label, async () => {
    const motion = { label, ...motionOf(content, unit) };
    return { motion, packed: motionData(motion, label, up) };
  })));
  const [read, motions] = [shown.map(({ motion }) => motion), shown.map(({ packed }) => packed)];
  Object.assign(state, { files, motions: read });
  complain("");
  const title = files.map(({ label }) => label).join(" and ");
  const page = { title, motions, alignment: null, overlay: false };
  const json = JSON.stringify(page).replace(/[<>&]/g, (character) => ESCAPED[character]);
  element("player").srcdoc = data.player.replace(data.marker, () => json);
  const sizes = motions.map(({ size }) => size);
  element("state").textContent = state.motions.map(({ label, rate, poses, skeleton }, i) =>
    `${label}: ${poses.length} frames at ${Number(rate.toPrecision(4))} Hz, ${skeleton.names.length} joints, `
    + `${sizes[i].toPrecision(3)} m`).join("; ");
  if (sizes.some((size) => size > TALL || size < SMALL)) {
    complain("No person has this size: choose another unit, as BVH files do not state theirs.");
  }
  state.shown = -1;
  state.problem = problemOf(state.motions);
}

/**
 * In words, why equal numbers are different poses in two motions, so that there is no distance; empty if they are not.
 * The rules are those of skpose/skeleton/_rest.py.
 */
function problemOf(motions) {
  if (motions.length < 2) return "";
  const [a, b] = motions.map(({ skeleton }) => skeleton);
  const only = (one, other) => one.names.filter((name) => !other.names.includes(name));
  const alone = [...only(a, b), ...only(b, a)];
  if (alone.length) return `Only one of the two has a joint ${alone[0]}: there is no distance; the library retargets.`;
  for (const [j, name] of a.names.entries()) {
    const k = b.names.indexOf(name);
    if (a.names[a.parents[j]] !== b.names[b.parents[k]] || a.dofs[j] !== b.dofs[k]) {
      return `${name} has another parent, or other axes, in the second file; the library makes both ball joints.`;
    }
    const [p, q] = [a.offsets[j], b.offsets[k]];
    const lengths = Math.hypot(...p) * Math.hypot(...q);
    const angle = lengths && Math.acos(Math.max(-1, Math.min(1, p.reduce((sum, x, i) => sum + x * q[i], 0) / lengths)));
    const degrees = (180 * angle) / Math.PI;
    if (degrees > data.constants.degrees + 1e-6) {
      return `${name} points in directions ${Math.round(degrees)}° apart at angle zero, so that equal numbers are `
        + "different poses.";
    }
  }
  return "";
}

/** Distances of a frame of the first motion to all frames of the last, on the skeleton of the first. */
function measure(frame) {
  const [first, last] = [state.motions[0], state.motions.at(-1)];
  const skeleton = (first.kinematics ??= new Skeleton(first.skeleton));
  const order = first.skeleton.columns.map((name) => last.skeleton.columns.indexOf(name));
  const from = first.poses[frame];
  const metric = value("metric");
  const placed = (pose) => Float64Array.from(order, (i) => pose[i]);
  return Float64Array.from(last.poses, (pose) => distances(skeleton, from, placed(pose))[metric]);
}

function follow() {
  const player = element("player").contentWindow?.skpose;
  const { motions } = state;
  const clips = player?.clock.clips ?? [];
  const shows = clips.length === motions.length // or it still has those before
    && motions.every(({ label, poses }, i) => clips[i].label === label && clips[i].frames === poses.length);
  if (shows && motions.length && !state.problem) {
    const [frame, other] = [0, motions.length - 1].map((i) => player.clock.frames(player.tick())[i]);
    if (frame !== state.shown) {
      Object.assign(state, { shown: frame, values: measure(frame) });
      draw(frame, other);
    }
  } else if (state.problem) {
    element("words").textContent = state.problem;
    sharpen(element("curve"), element("curve").getContext("2d"));
  }
  setTimeout(follow, PAUSE);
}

function draw(frame, other) {
  const { values, motions } = state;
  const [canvas, unit] = [element("curve"), data.constants.units[value("metric")]];
  const context = canvas.getContext("2d");
  sharpen(canvas, context);
  const [width, height, left] = [canvas.clientWidth, canvas.clientHeight - 22, 4];
  const most = values.reduce((a, b) => Math.max(a, b), 0) || 1;
  const x = (i) => left + ((width - 2 * left) * i) / Math.max(1, values.length - 1);
  const y = (distance) => height - (height - 8) * (distance / most);
  context.strokeStyle = colours.left;
  context.lineWidth = 2;
  context.beginPath();
  values.forEach((distance, i) => (i ? context.lineTo(x(i), y(distance)) : context.moveTo(x(i), y(distance))));
  context.stroke();
  // The nearest frame: of one motion alone the nearest one that is not a neighbour in time.
  const own = motions.length === 1;
  const apart = own ? Math.round(motions[0].rate / 3) : 0;
  let nearest = -1;
  values.forEach((distance, i) => {
    if ((!own || Math.abs(i - frame) > apart) && (nearest < 0 || distance < values[nearest])) nearest = i;
  });
  for (const [i, colour] of [[other, colours.ink], [nearest, colours.right]]) {
    if (i < 0) continue;
    context.fillStyle = colour;
    context.beginPath();
    context.arc(x(i), y(values[i]), 5, 0, 2 * Math.PI);
    context.fill();
  }
  Object.assign(context, { font: "12px system-ui, sans-serif", fillStyle: colours.quiet, textBaseline: "bottom" });
  context.fillText(own ? "all frames" : `all frames of ${motions[1].label}`, left, height + 20);
  const seconds = (i) => (i / motions.at(-1).rate).toFixed(2);
  const shown = own ? "" : `the pose next to it is ${values[other].toFixed(2)} ${unit} away, `;
  element("words").textContent = nearest < 0
    ? "There is no other frame that is not a neighbour in time."
    : `${shown}the nearest ${own ? "other" : "one"}, at ${seconds(nearest)} s, ${values[nearest].toFixed(2)} ${unit}.`;
}

element("files").addEventListener("change", (event) => read(event.target.files));
for (const id of ["unit", "up"]) element(id).addEventListener("change", () =>
  state.files.length && stated(() => show(state.files)));
element("metric").addEventListener("change", () => (state.shown = -1));
addEventListener("dragover", (event) => (event.preventDefault(), document.body.classList.add("over")));
addEventListener("dragleave", () => document.body.classList.remove("over"));
addEventListener("drop", (event) => {
  event.preventDefault();
  document.body.classList.remove("over");
  read(event.dataTransfer.files);
});
followTheme(element("theme"), () => (state.shown = -1));
read(data.examples.map(({ name, text }) => new File([text], name)));
follow();
window.drop = { state, read, readBvh, motionOf, sceneOf, shapeOf, splitSides, show }; // for tests
