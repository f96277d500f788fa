// Points in the plane, moved by mouse, fingers, wheel and keys, and enclosed by a lasso.

const SIDE = 4; // px, of the lasso at least, so that its corners are few

/**
 * Let a canvas move a scatter. `actions` are those of `listenForGestures`, and `lasso(corners)` with places of the
 * plane, while it is drawn, `lassoes()` whether a drag draws one, `go(right, up)` for the arrows.
 */
function moveScatter(canvas, scatter, actions) {
  let corners = null;
  listenForGestures(canvas, {
    ...actions,
    ready: (travelled) => travelled >= STILL,
    down: ({ x, y }, { shiftKey }, fingers) => {
      corners = fingers < 2 && (shiftKey || actions.lassoes()) ? [scatter.placeOf(x, y)] : null;
    },
    drag: (dx, dy, event, fingers, { x, y }) => {
      if (!corners) return scatter.pan(dx, dy);
      const [lastX, lastY] = scatter.seen(corners.at(-1));
      if (Math.hypot(x - lastX, y - lastY) < SIDE) return;
      corners.push(scatter.placeOf(x, y));
      actions.lasso(corners);
    },
    zoom: (factor, x, y) => scatter.zoomBy(factor, x, y),
    arrow: (right, up, shift) => (shift ? scatter.pan(-40 * right, 40 * up) : actions.go(right, up)),
  });
}
