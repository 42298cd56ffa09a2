// Parallel coordinates: a line a point, an axis for each objective and, if asked for, each gain. Axes are brushed.

const PARALLEL = { top: 46, bottom: 20, side: 60 };

function startParallel() {
  const canvas = byId("parallel");
  if (!canvas) return;
  const axes = () => (store.get().gains ? dimensions : dimensions.slice(0, objectives.length));
  const placeX = (k) => {
    const count = axes().length;
    return count > 1 ? PARALLEL.side + (k * (canvas.clientWidth - 2 * PARALLEL.side)) / (count - 1) : canvas.clientWidth / 2;
  };
  const scaleY = (axis) => makeScale(axis, canvas.clientHeight - PARALLEL.bottom, PARALLEL.top);
  const held = (value) => Math.min(Math.max(value, PARALLEL.top), canvas.clientHeight - PARALLEL.bottom);
  const line = (row) => axes().map((axis, k) => [placeX(k), held(scaleY(axis).to(row.values[axis.index]))]);

  addView(canvas, ["ranges", "layers", "picked", "gains"], (context, width, height) => {
    const { ranges, layers, picked } = store.get();
    const shown = axes();
    // A phone scrolls only where there are more axes than it has room for; a change of width paints again.
    canvas.style.minWidth = `${Math.min(34, 7 * shown.length)}rem`;
    const rows = visibleRows(layers);
    for (const keep of [false, true]) {
      for (const row of rows) if (passes(row, ranges) === keep && row.name !== picked) paintLine(context, row, line(row), keep);
    }
    if (byName.has(picked)) paintLine(context, byName.get(picked), line(byName.get(picked)), passes(byName.get(picked), ranges), true);
    shown.forEach((axis, k) => paintAxis(context, axis, placeX(k), scaleY(axis), ranges[axis.index], {
      height, room: (width - 2 * PARALLEL.side) / Math.max(shown.length - 1, 1) - 10, first: k === 0, last: k === shown.length - 1,
    }));
  });

  const axisAt = (x) => axes().findIndex((_, k) => Math.abs(placeX(k) - x) < 22);
  const lineAt = (rows, x, y) => rows.reduce((best, row) => {
    const apart = distanceToLine(line(row), x, y);
    return apart < (best?.apart ?? 10) ? { row, apart } : best;
  }, null)?.row;
  addPointer(canvas, {
    drag: (x0, y0, x1, y1) => {
      const k = axisAt(x0);
      if (k < 0) return;
      const axis = axes()[k];
      const ends = [y0, y1].map((y) => scaleY(axis).back(held(y)));
      store.set({ ranges: withRange(store.get().ranges, axis.index, [Math.min(...ends), Math.max(...ends)]) });
    },
    click: (x, y) => { const row = lineAt(finalists, x, y); if (row) pick(row.name); },
    hover: (x, y) => lineAt(finalists.filter((row) => store.get().layers[row.layer]), x, y),
  });
  canvas.addEventListener("dblclick", (event) => {
    const k = axisAt(event.offsetX);
    if (k >= 0) store.set({ ranges: withRange(store.get().ranges, axes()[k].index, null) });
  });
  addKeys(canvas, () => 0);
}

const DASHES = { default: [6, 4], start: [2, 3] };

function paintLine(context, row, points, selected, bold = false) {
  const special = row.layer === "default" || row.layer === "tuned";
  context.globalAlpha = (selected ? 1 : 0.12) * (row.low ? (special || bold ? 1 : 0.55) : 0.14);
  context.beginPath();
  points.forEach(([x, y], k) => context[k ? "lineTo" : "moveTo"](x, y));
  context.strokeStyle = bold && !special ? colour("ink") : colour(COLOURS[row.layer]);
  context.lineWidth = bold ? 2.8 : special ? 2.2 : 1;
  context.setLineDash(DASHES[row.layer] ?? []);
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
  if (special || bold) for (const [x, y] of points) mark(context, row.layer, x, y, selected ? 1 : 0.3, 0.9);
  if (row.point?.lost) for (const [x, y] of points.slice(0, objectives.length)) crossOut(context, x, y, selected ? 1 : 0.3, 0.6);
}

function paintAxis(context, axis, x, scale, range, { height, room, first, last }) {
  const [top, bottom] = [PARALLEL.top, height - PARALLEL.bottom];
  stroke(context, x, top, x, bottom, colour("muted"), 1.2);
  context.font = `11px ${typeface()}`;
  context.textBaseline = "middle";
  context.textAlign = last ? "left" : "right";
  for (const value of scale.ticks(5)) {
    const y = scale.to(value);
    const text = significant(value, 3);
    const wide = context.measureText(text).width;
    context.fillStyle = faded("surface", 0.8);
    context.fillRect(last ? x + 6 : x - 8 - wide, y - 7, wide + 3, 14);
    context.fillStyle = colour("muted");
    stroke(context, x - 3, y, x + 3, y, colour("muted"));
    context.fillText(text, last ? x + 7 : x - 7, y);
  }
  const [align, at] = first && !last ? ["left", 8] : last && !first ? ["right", x + PARALLEL.side - 8] : ["center", x];
  paintTitle(context, axis.name, at, 12, room, align);
  paintTitle(context, axis.unit ? `[${axis.unit}]` : "", at, 28, room, align);
  if (!range) return;
  const ends = range.map((end) => (Number.isFinite(end) ? Math.min(Math.max(scale.to(end), top), bottom) : end > 0 ? top : bottom));
  context.fillStyle = faded("tuned", 0.25);
  context.fillRect(x - 6, ends[1], 12, Math.max(ends[0] - ends[1], 2));
  context.strokeStyle = colour("tuned");
  context.lineWidth = 1.5;
  context.strokeRect(x - 6, ends[1], 12, Math.max(ends[0] - ends[1], 2));
}

function distanceToLine(points, x, y) {
  let least = points.length === 1 ? Math.hypot(points[0][0] - x, points[0][1] - y) : Infinity;
  for (let k = 1; k < points.length; k += 1) {
    const [[x1, y1], [x2, y2]] = [points[k - 1], points[k]];
    const t = Math.min(Math.max(((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / ((x2 - x1) ** 2 + (y2 - y1) ** 2), 0), 1);
    least = Math.min(least, Math.hypot(x1 + t * (x2 - x1) - x, y1 + t * (y2 - y1) - y));
  }
  return least;
}
