// The trade-off in two dimensions: the reader chooses which.

const PLANE = { left: 64, top: 14, right: 16, bottom: 46 };

function startPlane() {
  const canvas = byId("plane");
  if (!canvas) return;
  const box = () => ({
    left: PLANE.left, top: PLANE.top, right: canvas.clientWidth - PLANE.right, bottom: canvas.clientHeight - PLANE.bottom,
  });
  addView(canvas, ["ranges", "layers", "picked", "x", "y"], (context, width, height) => {
    const state = store.get();
    const area = box();
    paintFrame(context, area, state.x, state.y, [Math.min(7, width / 80), Math.min(7, height / 55)]);
    if (objectives.length === 2 && state.x === 0 && state.y === 1) paintStaircase(context, area);
    const rows = visibleRows(state.layers);
    paintScatter(context, area, state.x, state.y, rows, state);
    const shown = rows.filter((row) => shownIn(row, state.x, state.y));
    byId("beyond-legend").hidden = shown.every((row) => within(row, state.x, state.y));
    paintNames(context, area, state);
    paintTitle(context, axisTitle(dimensions[state.x]), (area.left + area.right) / 2, height - 12, area.right - area.left);
    paintTitle(context, axisTitle(dimensions[state.y]), 12, (area.top + area.bottom) / 2, area.bottom - area.top, "center", true);
  });
  const spot = (row) => {
    const { x, y } = store.get();
    return spotIn(box(), x, y, row);
  };
  const near = (rows, x, y) => nearestRow(rows.filter((row) => shownIn(row, store.get().x, store.get().y)), spot, x, y);
  addPointer(canvas, {
    drag: (x0, y0, x1, y1) => {
      const { ranges, x, y } = store.get();
      store.set({ ranges: brushed(ranges, box(), x, y, x0, y0, x1, y1) });
    },
    click: (x, y) => { const row = near(finalists, x, y); if (row) pick(row.name); },
    hover: (x, y) => near(visibleRows(store.get().layers), x, y),
  });
  canvas.addEventListener("dblclick", () => {
    const { ranges, x, y } = store.get();
    store.set({ ranges: withRange(withRange(ranges, x, null), y, null) });
  });
  addKeys(canvas, () => store.get().x);
}

// The boundary of what the front of two objectives dominates.
function paintStaircase(context, box) {
  const { x, y } = scalesOf(box, 0, 1);
  const front = finalists.filter((row) => row.point.front).sort((a, b) => a.values[0] - b.values[0]);
  if (!front.length) return;
  context.save();
  context.beginPath();
  context.rect(box.left, box.top, box.right - box.left, box.bottom - box.top);
  context.clip();
  context.beginPath();
  front.forEach((row, k) => {
    const [u, v] = [x.to(row.values[0]), y.to(row.values[1])];
    if (k) context.lineTo(u, y.to(front[k - 1].values[1]));
    context[k ? "lineTo" : "moveTo"](u, v);
  });
  context.setLineDash([1, 3]);
  context.strokeStyle = colour("front");
  context.lineWidth = 1.2;
  context.stroke();
  context.restore();
}

// Names beside the marks that matter.
function paintNames(context, box, { x: i, y: j, layers, picked }) {
  context.font = `600 12px ${typeface()}`;
  context.textBaseline = "bottom";
  for (const row of finalists) {
    const named = (row.layer === "default" || row.layer === "tuned") && layers[row.layer];
    if (!(named || row.name === picked) || !shownIn(row, i, j)) continue;
    const [u, v] = spotIn(box, i, j, row);
    const right = u > box.left + 0.8 * (box.right - box.left);
    context.textAlign = right ? "right" : "left";
    context.fillStyle = colour(named ? row.layer : "ink");
    context.fillText(named ? row.layer : row.name, u + (right ? -10 : 10), Math.max(v - 6, box.top + 12));
  }
}
