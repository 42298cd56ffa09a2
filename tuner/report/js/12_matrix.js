// A scatter matrix: every pair of objectives, for three and more of them.

function startMatrix() {
  const canvas = byId("matrix");
  if (!canvas) return;
  const count = Math.min(objectives.length, 6);
  const cell = (row, column) => {
    const [width, height] = [(canvas.clientWidth - 64) / (count - 1), (canvas.clientHeight - 40) / (count - 1)];
    const [left, top] = [64 + column * width, (row - 1) * height];
    return { left: left + 8, top: top + 8, right: left + width - 8, bottom: top + height - 8 };
  };
  const cells = [];
  for (let row = 1; row < count; row += 1) for (let column = 0; column < row; column += 1) cells.push([column, row]);
  const inCell = (x, y) => cells.find(([i, j]) => {
    const box = cell(j, i);
    return x >= box.left - 8 && x <= box.right + 8 && y >= box.top - 8 && y <= box.bottom + 8;
  });
  addView(canvas, ["ranges", "layers", "picked"], (context, width, height) => {
    const state = store.get();
    const rows = visibleRows(state.layers);
    for (const [i, j] of cells) {
      const box = cell(j, i);
      paintFrame(context, box, i, j, [j === count - 1 ? 4 : 0, i === 0 ? 4 : 0]);
      paintScatter(context, box, i, j, rows, state, 0.7);
      const title = objectives[j].label;
      if (i === 0) paintTitle(context, title, 10, (box.top + box.bottom) / 2, box.bottom - box.top, "center", true);
      if (j === count - 1) paintTitle(context, objectives[i].label, (box.left + box.right) / 2, height - 8, box.right - box.left);
    }
  });
  const spot = ([i, j]) => (row) => spotIn(cell(j, i), i, j, row);
  const near = (rows, x, y) => {
    const found = inCell(x, y);
    return found ? nearestRow(rows.filter((row) => shownIn(row, ...found)), spot(found), x, y, 10) : null;
  };
  addPointer(canvas, {
    drag: (x0, y0, x1, y1) => {
      const found = inCell(x0, y0);
      if (found) store.set({ ranges: brushed(store.get().ranges, cell(found[1], found[0]), ...found, x0, y0, x1, y1) });
    },
    click: (x, y) => { const row = near(finalists, x, y); if (row) pick(row.name); },
    hover: (x, y) => near(visibleRows(store.get().layers), x, y),
  });
  canvas.addEventListener("dblclick", () => store.set({ ranges: Object.freeze({}) }));
  addKeys(canvas, () => 0);
}
