// Two dimensions of all visible rows in a box of a canvas; the plane and every cell of the matrix are made of it.

// Scales of a box {left, top, right, bottom} for two dimensions; up is more.
const scalesOf = (box, i, j) => ({
  x: makeScale(dimensions[i], box.left, box.right),
  y: makeScale(dimensions[j], box.bottom, box.top),
});

const inSpan = (value, { low, high }) => value >= low && value <= high;
const within = (row, i, j) => inSpan(row.values[i], dimensions[i]) && inSpan(row.values[j], dimensions[j]);
// What was flown on held-out scenarios is drawn wherever it lies, at the edge where it lies beyond the axes.
const shownIn = (row, i, j) => within(row, i, j) || (Boolean(row.low) && [i, j].every((k) => isNumber(row.values[k])));

// Place of a row in a box, at its edge where the row lies beyond the axes.
function spotIn(box, i, j, row) {
  const { x, y } = scalesOf(box, i, j);
  return [
    Math.min(Math.max(x.to(row.values[i]), box.left), box.right),
    Math.min(Math.max(y.to(row.values[j]), box.top), box.bottom),
  ];
}

function paintScatter(context, box, i, j, rows, { ranges, layers, picked }, scale = 1) {
  const { x, y } = scalesOf(box, i, j);
  context.save();
  context.beginPath();
  context.rect(box.left - 8, box.top - 8, box.right - box.left + 16, box.bottom - box.top + 16);
  context.clip();
  paintRanges(context, box, i, j, ranges, x, y);
  for (const row of rows) {
    if (!shownIn(row, i, j)) continue;
    const opacity = passes(row, ranges) ? 1 : 0.16;
    const [u, v] = spotIn(box, i, j, row);
    if (within(row, i, j)) {
      if (layers.intervals && row.low) paintBars(context, row, i, j, x, y, u, v, opacity * 0.5);
      mark(context, row.layer, u, v, row.low ? opacity : opacity * 0.7, scale);
    } else arrowHead(context, row.layer, u, v, beyond(row, i, j), opacity, scale);
    if (row.point?.lost) crossOut(context, u, v, opacity, scale);
    if (row.name === picked) ring(context, u, v, 10 * scale);
  }
  context.restore();
}

// Which way a row lies beyond the axes on the paper: -1, 0 or 1 to the right and down.
function beyond(row, i, j) {
  const side = (value, { low, high }) => (value > high ? 1 : value < low ? -1 : 0);
  return [side(row.values[i], dimensions[i]), -side(row.values[j], dimensions[j])];
}

// Held-out intervals of the objectives; gains have none.
function paintBars(context, row, i, j, x, y, u, v, opacity) {
  context.globalAlpha = opacity;
  const style = colour(COLOURS[row.layer]);
  if (i < objectives.length && isNumber(row.low[i])) stroke(context, x.to(row.low[i]), v, x.to(row.high[i]), v, style);
  if (j < objectives.length && isNumber(row.low[j])) stroke(context, u, y.to(row.low[j]), u, y.to(row.high[j]), style);
  context.globalAlpha = 1;
}

// What is selected, as a tinted part of the box with dashed edges.
function paintRanges(context, box, i, j, ranges, x, y) {
  if (!ranges[i] && !ranges[j]) return;
  const clip = (value, a, b) => Math.min(Math.max(value, Math.min(a, b)), Math.max(a, b));
  const ends = (range, scale, a, b) => (range ? range.map((end) =>
    (Number.isFinite(end) ? clip(scale.to(end), a, b) : end > 0 ? b : a)) : [a, b]);
  const [x1, x2] = ends(ranges[i], x, box.left, box.right);
  const [y1, y2] = ends(ranges[j], y, box.bottom, box.top);
  context.fillStyle = faded("tuned", 0.08);
  context.fillRect(x1, y2, x2 - x1, y1 - y2);
  context.setLineDash([4, 3]);
  context.strokeStyle = faded("tuned", 0.7);
  context.lineWidth = 1;
  context.strokeRect(x1, y2, x2 - x1, y1 - y2);
  context.setLineDash([]);
}

// A frame with grid lines; ticks: how many numbers at most along x and y, 0 for none.
function paintFrame(context, box, i, j, ticks) {
  const { x, y } = scalesOf(box, i, j);
  context.fillStyle = colour("muted");
  context.font = `11px ${typeface()}`;
  context.textBaseline = "middle";
  for (const value of x.ticks(ticks[0] || 4)) {
    stroke(context, x.to(value), box.top, x.to(value), box.bottom, colour("grid"));
    context.textAlign = "center";
    if (ticks[0]) context.fillText(significant(value, 3), x.to(value), box.bottom + 11);
  }
  for (const value of y.ticks(ticks[1] || 4)) {
    stroke(context, box.left, y.to(value), box.right, y.to(value), colour("grid"));
    context.textAlign = "right";
    if (ticks[1]) context.fillText(significant(value, 3), box.left - 6, y.to(value));
  }
  stroke(context, box.left, box.bottom, box.right, box.bottom, colour("line"));
  stroke(context, box.left, box.top, box.left, box.bottom, colour("line"));
}

// The selection that a rectangle drawn with the pointer stands for.
function brushed(ranges, box, i, j, x0, y0, x1, y1) {
  const { x, y } = scalesOf(box, i, j);
  const ordered = (a, b) => [Math.min(a, b), Math.max(a, b)];
  const across = withRange(ranges, i, ordered(x.back(x0), x.back(x1)));
  return i === j ? across : withRange(across, j, ordered(y.back(y0), y.back(y1)));
}

// A title of an axis, cut where it does not fit.
function paintTitle(context, text, x, y, most, align = "center", turned = false) {
  context.save();
  context.translate(x, y);
  if (turned) context.rotate(-Math.PI / 2);
  context.textAlign = align;
  context.textBaseline = "middle";
  context.fillStyle = colour("muted");
  context.font = `12px ${typeface()}`;
  let shown = text;
  while (shown.length > 4 && context.measureText(shown).width > most) shown = `${shown.slice(0, -2).trimEnd()}…`;
  context.fillText(shown, 0, 0);
  context.restore();
}

const axisTitle = ({ name, label, unit }) => (unit ? `${name ?? label} [${unit}]` : name ?? label);
