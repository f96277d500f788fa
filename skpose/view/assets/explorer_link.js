// What is in a link to an explorer, and how a link is shown.

/** What is in a link. While a motion plays its pose is in it nevertheless. */
function linked() {
  const { comparison, current, first, share, group } = state;
  const camera = cameraWord(view.camera);
  return {
    metric: element("metric").value === usual.metric ? null : element("metric").value,
    method: element("method").value === usual.method ? null : element("method").value,
    figures: element("figures").checked ? null : "0",
    colour: element("colour").value === usual.colour ? null : element("colour").value,
    group: group < 0 ? null : group,
    pose: current || null,
    first: first >= 0 && !comparison ? first : null,
    compared: comparison ? wordOf(comparison.first, comparison.second, share) : null,
    lasso: state.lasso.length > 2 ? preciseWord(...state.lasso.flat()) : null,
    plane: scatter.isHome ? null : preciseWord(scatter.zoom, ...scatter.centre),
    camera: camera === usual.camera ? null : camera,
  };
}

/** Show what a link says; what it does not say, or says wrongly, is as usual. */
function restore(words) {
  const row = (value) => (Number.isInteger(value) && value >= 0 && value < poses.count ? value : -1);
  Object.assign(state, { comparison: null, first: -1, group: -1, hover: -1 });
  scatter.absent = null;
  for (const id of ["metric", "method", "colour"]) setControl(element(id), words.get(id), usual[id]);
  element("figures").checked = words.get("figures") !== "0";
  choosePlane();
  writeGroups();
  const [pose, first] = ["pose", "first"].map((name) => row(numbersIn(words.get(name), 1)?.[0]));
  show(Math.max(0, pose));
  state.first = first;
  const compared = numbersIn(words.get("compared"), 3);
  if (compared && row(compared[0]) >= 0 && row(compared[1]) >= 0) {
    state.first = compared[0];
    choose(compared[1], true);
    state.share = clamp(compared[2], 0, 1);
  }
  const group = numbersIn(words.get("group"), 1)?.[0];
  if (Number.isInteger(group)) element("groups").querySelectorAll("button")[group]?.click(); // before what is inside
  const places = numbersIn(words.get("lasso"), (words.get("lasso") ?? "").split(",").length) ?? [];
  const corners = Array.from({ length: Math.floor(places.length / 2) }, (_, i) => places.slice(2 * i, 2 * i + 2));
  enclose(corners.length > 2 ? corners : []);
  view.fit(true);
  usual.camera = cameraWord(view.camera);
  restoreCamera(view.camera, words.get("camera"));
  const plane = numbersIn(words.get("plane"), 3);
  if (plane) scatter.zoomTo(plane[0], plane.slice(1));
  play(![...words.keys()].length && !calm.matches); // a link shows what it says
  colour();
  writeComparison();
  announce();
}
