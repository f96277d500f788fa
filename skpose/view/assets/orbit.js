// A camera moved by mouse, fingers, wheel and keys.

const TURN = 0.008; // rad per px
const STEP = 0.12; // rad per key

/**
 * Let a canvas move a camera. `actions` are called by name: `moved` after each change of the camera,
 * `point(x, y, touch)` where a pointer is over the canvas, `leave`, `home`; `keys` is a table of what other keys do.
 */
function orbit(canvas, camera, actions) {
  const fingers = new Map();
  let travelled = 0;
  const at = ({ clientX, clientY }) => {
    const { left, top } = canvas.getBoundingClientRect();
    return { x: clientX - left, y: clientY - top };
  };
  /** Middle of all fingers, and the distance between two. */
  const grip = () => {
    const [a, b = a] = fingers.values();
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, span: Math.hypot(a.x - b.x, a.y - b.y) };
  };
  /** Shares of the distance by which a movement in px shifts what is seen. */
  const shift = (dx, dy) => {
    const unit = (2 * FIELD) / Math.min(canvas.clientWidth, canvas.clientHeight);
    camera.pan(-dx * unit, dy * unit);
  };

  canvas.addEventListener("pointerdown", (event) => {
    if (!fingers.size) travelled = 0;
    fingers.set(event.pointerId, at(event));
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true, focusVisible: false });
  });
  canvas.addEventListener("pointermove", (event) => {
    const place = at(event);
    if (!fingers.has(event.pointerId)) return actions.point(place.x, place.y, false);
    const before = grip();
    fingers.set(event.pointerId, place);
    const { x, y, span } = grip();
    const [dx, dy] = [x - before.x, y - before.y];
    travelled += Math.hypot(dx, dy);
    if (fingers.size > 1) {
      if (before.span > 0) camera.zoomBy(span / before.span);
      shift(dx, dy);
    } else if (event.shiftKey || event.buttons > 1) shift(dx, dy);
    else camera.turn(TURN * dx, TURN * dy);
    actions.moved();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (fingers.delete(event.pointerId) && event.pointerType === "touch" && travelled < 6) {
      const { x, y } = at(event);
      actions.point(x, y, true);
    }
  });
  canvas.addEventListener("pointercancel", (event) => fingers.delete(event.pointerId)); // the page scrolls
  // Two fingers are for the picture; one that goes up or down scrolls a page that is longer than the window.
  canvas.addEventListener("touchmove", (event) => {
    if (event.touches.length > 1 && event.cancelable) event.preventDefault();
  }, { passive: false });
  const fits = new ResizeObserver(() => {
    const { scrollHeight, clientHeight } = document.documentElement;
    canvas.style.touchAction = window !== window.parent || scrollHeight > clientHeight ? "pan-y" : "none";
  });
  for (const one of [document.documentElement, document.body]) fits.observe(one);
  canvas.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && actions.leave());
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", () => actions.home());
  canvas.addEventListener("wheel", (event) => {
    // In a frame of a notebook the wheel scrolls the notebook, unless the picture is in use.
    if (window !== window.parent && document.activeElement !== canvas) return;
    event.preventDefault();
    camera.zoomBy(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)));
    actions.moved();
  }, { passive: false });

  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const [dx, dy] = arrows[event.key] ?? [0, 0];
    if (dx || dy) {
      if (event.shiftKey) shift(30 * dx, 30 * dy);
      else camera.turn(STEP * dx, STEP * dy);
      actions.moved();
    } else if (event.key === "+" || event.key === "=" || event.key === "-") {
      camera.zoomBy(event.key === "-" ? 1 / 1.2 : 1.2);
      actions.moved();
    } else if (event.key === "0") actions.home();
    else if (actions.keys[event.key]) actions.keys[event.key]();
    else return;
    event.preventDefault();
  });
}

/**
 * Keep a camera so far above the ground, y = 0, m: where it has been moved since the last call it stays where it can
 * be, and otherwise looks less from below. `height` is that of its target.
 */
function keepAbove(camera, height, least) {
  const { distance, shift: [, up], kept = up } = camera;
  const [far, side] = [distance / camera.zoom, up * distance];
  const eye = () => height + far * Math.sin(camera.elevation) + camera.shift[1] * distance * Math.cos(camera.elevation);
  if (kept === up && eye() < least) {
    const share = Math.max(-1, Math.min(1, (least - height) / Math.hypot(far, side)));
    camera.elevation = Math.max(camera.elevation, Math.min(1.55, Math.asin(share) - Math.atan2(side, far)));
  }
  if (eye() < least) {
    const shift = (least - height - far * Math.sin(camera.elevation)) / (distance * Math.cos(camera.elevation));
    camera.shift = [camera.shift[0], shift];
  }
  camera.kept = camera.shift[1];
}
