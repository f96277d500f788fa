// The texts of an explorer. Names come from files: they are text, never markup.

const count = (n, word) => `${n.toLocaleString("en")} ${word}${n === 1 ? "" : "s"}`;
const named = (row) => [textElement("span", poses.label(row)), `, ${seconds(row)}`];
const seconds = (row) => `${poses.time(row).toFixed(2)} s`;
const nameOf = (row) => `${poses.label(row)}, ${seconds(row)}`;

function describe() {
  const { title, error, rate, skeleton, embeddings, groups } = data;
  const joints = count(skeleton.names.length, "joint");
  const facts = `${count(poses.count, "pose")} of ${count(data.labels.length, "motion")}`;
  element("title").append(textElement("span", title, { title }));
  element("summary").textContent = title === facts ? joints : facts;
  const lines = [
    `${facts}${rate ? `, ${Number(rate.toPrecision(4))} poses a second` : ""}; ${joints}.`,
    `Joints are within ${error.toPrecision(2)} mm of those of the poses, which are rounded.`,
    ...embeddings.filter(({ share }) => share !== null).map(({ metric, share }) =>
      `${metric}: the plane of multidimensional scaling has ${(100 * share).toFixed(0)} % of the variance.`),
  ];
  element("facts").append(...lines.map((line) => textElement("li", line)));
  const options = (values) => [...new Set(values)].map((value) => textElement("option", value, { value }));
  element("metric").append(...options(embeddings.map(({ metric }) => metric)));
  element("method").append(...options(embeddings.map(({ method }) => method)));
  element("methods").hidden = element("method").options.length < 2;
  element("colour").append(...options([...groups.map(({ by }) => by), "motion", "time"]));
  const several = groups.filter(({ names }) => names.length > 1); // one colour says nothing
  element("colour").value = (several.find(({ by }) => by === "action") ?? several[0])?.by ?? "motion";
}

function write() {
  const { hover, current, comparison } = state;
  const row = hover >= 0 ? hover : current;
  element("caption").replaceChildren(...(hover < 0 && comparison ? [comparison.label] : named(row)));
  const played = poses.range(current);
  const [time, most] = [element("time"), comparison ? PARTS : played.end - played.first - 1];
  if (Number(time.max) !== most) time.max = most;
  time.value = position();
  time.setAttribute("aria-label", comparison ? "Share of the line" : "Time");
  const share = `${Math.round(100 * state.share)} %`;
  time.setAttribute("aria-valuetext", comparison ? share
    : `${poses.time(current).toFixed(2)} seconds, pose ${current - played.first + 1} of ${most + 1}`);
  element("clock").textContent = comparison ? share : seconds(current);
  const [x, y] = hover < 0 ? [] : scatter.at(hover);
  showTip(element("tip"), scatter.canvas, { x, y }, hover < 0 ? null : named(hover));
}

/** What is written in a picture: which pose or line it shows, and what the colours mean. */
function keyOf({ hover, current, comparison }) {
  const { names, longest } = poses.groups(element("colour").value);
  const groupOf = (words, i) => ({ words: words || "unnamed", colour: groupColour(i), form: formOf(i) });
  const timeOf = (share) => ({ words: `${(share * longest).toFixed(2)} s`, colour: heat(share), form: 0 });
  const groups = names ? names.map(groupOf) : [0, 0.5, 1].map(timeOf);
  return { name: hover < 0 && comparison ? comparison.label : nameOf(hover >= 0 ? hover : current), groups };
}

/** Say, to those who do not see it, which pose has been reached or chosen, what it is compared with, what is inside. */
function announce() {
  const { hover, current, comparison, lasso, inside } = state;
  const words = named(hover >= 0 ? hover : current);
  if (hover < 0 && comparison) {
    words.push(" compared with ", ...named(comparison.first), `; ${comparison.label}`);
  }
  if (lasso.length) words.push(`; lasso of ${count(lasso.length, "corner")}`);
  if (inside) words.push(`, ${count(inside.length, "pose")} inside`);
  element("status").replaceChildren(...words);
}

function writeComparison() {
  const { comparison } = state;
  element("compared").hidden = !comparison;
  if (!comparison) return;
  element("pair").replaceChildren(
    "A: ", textElement("span", nameOf(comparison.first)), "; B: ", textElement("span", nameOf(comparison.second)),
  );
  element("distances").replaceChildren(...comparison.rows.map((cells) => {
    const row = document.createElement("tr");
    row.append(...cells.map((cell, i) => textElement(i ? "td" : "th", cell, i ? {} : { scope: "row" })));
    return row;
  }));
}

function listed(name, number, { swatch = -1, press, pressed }) {
  const [item, button] = [document.createElement("li"), document.createElement("button")];
  button.type = "button";
  if (swatch >= 0) {
    button.append(Object.assign(textElement("span", "", { className: "swatch" }), { group: swatch }));
    button.setAttribute("aria-pressed", pressed);
  }
  button.append(textElement("span", name, { className: "name" }), textElement("span", number, { className: "number" }));
  button.addEventListener("click", press);
  item.append(button);
  return item;
}

function writeInside() {
  const { inside } = state;
  element("inside").hidden = !inside;
  if (!inside) return;
  const found = countMotions(poses, inside);
  element("count").textContent = `${count(inside.length, "pose")} of ${count(found.length, "motion")}`;
  element("motions").replaceChildren(...found.map(({ motion, count: n, first }) =>
    listed(data.labels[motion], `${n} of ${data.counts[motion]}`, { press: () => choose(first, false) })));
}

function writeGroups() {
  const { names, of, longest } = poses.groups(element("colour").value);
  element("scale").hidden = Boolean(names);
  element("groups").hidden = !names;
  element("most").textContent = names ? "" : `${longest.toFixed(2)} s`;
  const counts = new Uint32Array(names?.length ?? 0);
  if (names) for (const group of of) counts[group]++;
  const press = (group) => () => {
    state.group = state.group === group ? -1 : group;
    for (const [i, button] of element("groups").querySelectorAll("button").entries()) {
      button.setAttribute("aria-pressed", i === state.group);
    }
    fade();
  };
  element("groups").replaceChildren(...(names ?? []).map((name, group) => {
    const number = counts[group].toLocaleString("en");
    return listed(name || "unnamed", number, { swatch: group, press: press(group), pressed: false });
  }));
}
