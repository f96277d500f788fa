// Mouse, fingers, wheel and keys on a canvas.

const STILL = 6; // px that a click may move
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/**
 * Call the functions of a table: `drag(dx, dy, event, fingers, place)`, `zoom(factor, x, y)`, `arrow(right, up, shift)`,
 * `moved()` after each of these, `point(x, y)` where a pointer is over the canvas, `leave()`, `click(x, y, event)`;
 * `keys` is a table of other keys. Optional: `down(place, event, fingers)`, and `ready(pixels)`, whether a drag begins.
 */
function listenForGestures(canvas, on) {
  const fingers = new Map();
  let [travelled, several] = [0, false];
  const at = ({ clientX, clientY }) => {
    const { left, top } = canvas.getBoundingClientRect();
    return { x: clientX - left, y: clientY - top };
  };
  const grip = () => {
    const [a, b = a] = fingers.values();
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, span: Math.hypot(a.x - b.x, a.y - b.y) };
  };

  canvas.addEventListener("pointerdown", (event) => {
    if (!fingers.size) [travelled, several] = [0, false];
    fingers.set(event.pointerId, at(event));
    several ||= fingers.size > 1;
    on.down?.(at(event), event, fingers.size);
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true, focusVisible: false });
  });
  canvas.addEventListener("pointermove", (event) => {
    const place = at(event);
    if (!fingers.has(event.pointerId)) return on.point(place.x, place.y);
    const before = grip();
    fingers.set(event.pointerId, place);
    const { x, y, span } = grip();
    travelled += Math.hypot(x - before.x, y - before.y) + Math.abs(span - before.span);
    if (!(on.ready?.(travelled) ?? true)) return;
    on.drag(x - before.x, y - before.y, event, fingers.size, place);
    if (before.span > 0 && span > 0) on.zoom(span / before.span, x, y);
    on.moved();
  });
  canvas.addEventListener("pointerup", (event) => {
    const { x, y } = at(event);
    if (fingers.delete(event.pointerId) && !several && travelled < STILL) on.click(x, y, event);
  });
  canvas.addEventListener("pointercancel", (event) => fingers.delete(event.pointerId)); // the page scrolls
  canvas.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && on.leave());
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    // In a frame of a notebook the wheel scrolls the notebook, unless the picture is in use.
    if (window !== window.parent && document.activeElement !== canvas) return;
    event.preventDefault();
    const { x, y } = at(event);
    on.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), x, y);
    on.moved();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const [right, up] = ARROWS[event.key] ?? [0, 0];
    if (right || up) on.arrow(right, up, event.shiftKey);
    else if ("+=-".includes(event.key)) on.zoom(event.key === "-" ? 1 / 1.25 : 1.25);
    else if (on.keys[event.key]) on.keys[event.key](event.shiftKey);
    else return;
    on.moved();
    event.preventDefault();
  });
}

/** Show an element with words next to a place of a canvas, inside of it; hide it without words. */
function showTip(tip, { clientWidth, clientHeight }, { x, y }, words) {
  tip.hidden = !words;
  if (!words) return;
  tip.replaceChildren(...words);
  const left = x + 14 + tip.offsetWidth > clientWidth ? x - 14 - tip.offsetWidth : x + 14;
  tip.style.left = `${Math.max(4, left)}px`;
  tip.style.top = `${Math.max(4, Math.min(y + 12, clientHeight - tip.offsetHeight - 4))}px`;
}
