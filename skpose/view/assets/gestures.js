// Points in the plane, moved by mouse, fingers, wheel and keys; clicks, and the lasso.

const STILL = 6; // px that a click may move
const SIDE = 4; // px, of the lasso at least, so that its corners are few

/**
 * Let a canvas move a scatter. `actions` are called by name: `moved` after each change of the view, `point(x, y)` where
 * a pointer is over the canvas, `leave`, `click(x, y, shift)`, `lasso(corners)` with places of the plane, while it is
 * drawn, `lassoes()` whether a drag draws one; `go(right, up)` for the arrows, and `keys`, a table of other keys.
 */
function gestures(canvas, scatter, actions) {
  const fingers = new Map();
  let [travelled, corners, several] = [0, null, false];
  const at = ({ clientX, clientY }) => {
    const { left, top } = canvas.getBoundingClientRect();
    return { x: clientX - left, y: clientY - top };
  };
  /** Middle of all fingers, and the distance between two. */
  const grip = () => {
    const [a, b = a] = fingers.values();
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, span: Math.hypot(a.x - b.x, a.y - b.y) };
  };

  canvas.addEventListener("pointerdown", (event) => {
    const place = at(event);
    if (!fingers.size) [travelled, several] = [0, false];
    fingers.set(event.pointerId, place);
    several ||= fingers.size > 1;
    corners = !several && (event.shiftKey || actions.lassoes()) ? [scatter.placeOf(place.x, place.y)] : null;
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true, focusVisible: false });
  });
  canvas.addEventListener("pointermove", (event) => {
    const place = at(event);
    if (!fingers.has(event.pointerId)) return actions.point(place.x, place.y);
    const before = grip();
    fingers.set(event.pointerId, place);
    const { x, y, span } = grip();
    travelled += Math.hypot(x - before.x, y - before.y) + Math.abs(span - before.span);
    if (travelled < STILL) return;
    if (corners) {
      const [lastX, lastY] = scatter.seen(corners.at(-1));
      if (Math.hypot(x - lastX, y - lastY) < SIDE) return;
      corners.push(scatter.placeOf(x, y));
      return actions.lasso(corners);
    }
    scatter.pan(x - before.x, y - before.y);
    if (several && before.span > 0 && span > 0) scatter.zoomBy(span / before.span, x, y);
    actions.moved();
  });
  const release = (event) => {
    if (!fingers.delete(event.pointerId) || fingers.size || several || travelled >= STILL) return;
    const { x, y } = at(event);
    actions.click(x, y, event.shiftKey);
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && actions.leave());
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    // In a frame of a notebook the wheel scrolls the notebook, unless the picture is in use.
    if (window !== window.parent && document.activeElement !== canvas) return;
    event.preventDefault();
    const { x, y } = at(event);
    scatter.zoomBy(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), x, y);
    actions.moved();
  }, { passive: false });

  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const [right, up] = arrows[event.key] ?? [0, 0];
    if (right || up) {
      if (event.shiftKey) scatter.pan(-40 * right, 40 * up), actions.moved();
      else actions.go(right, up);
    } else if (event.key === "+" || event.key === "=" || event.key === "-") {
      scatter.zoomBy(event.key === "-" ? 1 / 1.25 : 1.25);
      actions.moved();
    } else if (actions.keys[event.key]) actions.keys[event.key](event.shiftKey);
    else return;
    event.preventDefault();
  });
}
