// What is drawn over the points of an explorer: the motion that plays, chosen poses, the lasso, a scale.

const TRACE = 800; // points of a motion's line at most

function drawMarks(context, scatter, poses, { hover, first, current, comparison, lasso, unit }, drawFigures) {
  drawFigures(context);
  drawTrace(context, scatter, poses.range(current));
  context.lineWidth = 2;
  context.strokeStyle = context.fillStyle = colours.ink;
  if (comparison) {
    context.setLineDash([6, 4]);
    polyline(context, [comparison.first, comparison.second].map((row) => scatter.at(row)));
    context.setLineDash([]);
    drawLetter(context, scatter.at(comparison.first), "A");
    drawLetter(context, scatter.at(comparison.second), "B");
  } else {
    if (first >= 0) drawLetter(context, scatter.at(first), "A");
    dot(context, scatter.at(current), 6, colours.ink);
  }
  if (hover >= 0) {
    const [x, y] = scatter.at(hover);
    drawRing(context, { x, y });
  }
  if (lasso.length) drawLasso(context, lasso.map((corner) => scatter.seen(corner)));
  if (unit) drawScale(context, scatter, unit);
}

function polyline(context, places) {
  context.beginPath();
  for (const [x, y] of places) context.lineTo(x, y);
  context.stroke();
}

function dot(context, [x, y], radius, colour) {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  Object.assign(context, { fillStyle: colour, strokeStyle: colours.paper, lineWidth: 2 });
  context.fill();
  context.stroke();
}

function drawTrace(context, scatter, { first, end }) {
  const stride = Math.ceil((end - first) / TRACE);
  const places = [];
  for (let row = first; row < end; row += stride) places.push(scatter.at(row));
  Object.assign(context, { strokeStyle: colours.ink, lineWidth: 1.5, lineJoin: "round", globalAlpha: 0.55 });
  polyline(context, places);
  context.globalAlpha = 1;
}

function drawLetter(context, place, letter) {
  dot(context, place, 10, colours.ink);
  Object.assign(context, {
    font: "bold 12px system-ui, sans-serif", textAlign: "center", textBaseline: "middle", fillStyle: colours.paper,
  });
  context.fillText(letter, ...place);
}

function drawLasso(context, corners) {
  context.beginPath();
  for (const [x, y] of corners) context.lineTo(x, y);
  context.closePath();
  context.globalAlpha = 0.12;
  context.fillStyle = colours.accent;
  context.fill("evenodd");
  context.globalAlpha = 1;
  Object.assign(context, { strokeStyle: colours.accent, lineWidth: 2 });
  context.stroke();
  if (corners.length < 3) for (const corner of corners) dot(context, corner, 4, colours.accent);
}

function drawScale(context, scatter, unit) {
  const length = cellOf((0.6 * scatter.width) / scatter.scale);
  const [x, y, width] = [16, scatter.height - 14, length * scatter.scale];
  Object.assign(context, { strokeStyle: colours.quiet, lineWidth: 2 });
  polyline(context, [[x, y - 5], [x, y], [x + width, y], [x + width, y - 5]]);
  Object.assign(context, {
    font: "13px system-ui, sans-serif", textAlign: "left", textBaseline: "alphabetic", fillStyle: colours.quiet,
  });
  context.fillText(`${Number(length.toPrecision(3))} ${unit}`, x, y - 9);
}
