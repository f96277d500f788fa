// A camera moved by mouse, fingers, wheel and keys.

const TURN = 0.008; // rad per px
const STEP = 0.12; // rad per key

/** Let a canvas move a camera. `actions` are those of `listenForGestures`, and `home()`. */
function orbit(canvas, camera, actions) {
  const shift = (dx, dy) => {
    const unit = (2 * FIELD) / Math.min(canvas.clientWidth, canvas.clientHeight);
    camera.pan(-dx * unit, dy * unit);
  };
  listenForGestures(canvas, {
    ...actions,
    drag: (dx, dy, { shiftKey, buttons }, fingers) => {
      if (fingers > 1 || shiftKey || buttons > 1) shift(dx, dy);
      else camera.turn(TURN * dx, TURN * dy);
    },
    click: (x, y, { pointerType }) => pointerType === "touch" && actions.point(x, y, true),
    zoom: (factor) => camera.zoomBy(factor),
    arrow: (right, up, shifted) =>
      (shifted ? shift(30 * right, -30 * up) : camera.turn(STEP * right, -STEP * up)),
    keys: { ...actions.keys, 0: actions.home },
  });
  canvas.addEventListener("dblclick", actions.home);
  // Two fingers are for the picture; one that goes up or down scrolls a page that is longer than the window.
  canvas.addEventListener("touchmove", (event) => {
    if (event.touches.length > 1 && event.cancelable) event.preventDefault();
  }, { passive: false });
  const fits = new ResizeObserver(() => {
    const { scrollHeight, clientHeight } = document.documentElement;
    canvas.style.touchAction = window !== window.parent || scrollHeight > clientHeight ? "pan-y" : "none";
  });
  for (const one of [document.documentElement, document.body]) fits.observe(one);
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
