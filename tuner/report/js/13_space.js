// Three objectives in space: an orthographic view that is turned by dragging or with the arrow keys. No WebGL is needed.

const turn = { azimuth: -0.7, elevation: 0.45 };

// Place on the paper of a point of the unit cube; depth grows towards the reader.
function projected([x, y, z], width, height) {
  const [a, b, c] = [x - 0.5, y - 0.5, z - 0.5];
  const [sin, cos] = [Math.sin(turn.azimuth), Math.cos(turn.azimuth)];
  const [u, w] = [a * cos - b * sin, a * sin + b * cos];
  const [rise, fall] = [Math.sin(turn.elevation), Math.cos(turn.elevation)];
  const size = Math.min(width, height) * 0.58;
  return [width / 2 + u * size, height / 2 - 8 - (c * fall + w * rise) * size, -w * fall + c * rise];
}

function startSpace() {
  const canvas = byId("space");
  if (!canvas) return;
  const scales = [0, 1, 2].map((i) => makeScale(dimensions[i], 0, 1));
  const at = (scale, value) => Math.min(Math.max(scale.to(value), 0), 1);
  const placeOf = (row, width, height) => projected(scales.map((scale, i) => at(scale, row.values[i])), width, height);
  const inside = (row) => scales.every((scale, i) => scale.inside(row.values[i]));
  const drawn = (row) => inside(row) || (Boolean(row.low) && scales.every((_, i) => isNumber(row.values[i])));
  const view = addView(canvas, ["ranges", "layers", "picked"], (context, width, height) => {
    const { ranges, layers, picked } = store.get();
    paintCube(context, width, height, scales);
    const rows = visibleRows(layers).filter(drawn).map((row) => ({ row, at: placeOf(row, width, height) }));
    for (const { row, at } of rows.sort((a, b) => a.at[2] - b.at[2])) {
      const opacity = passes(row, ranges) ? 1 : 0.16;
      if (inside(row)) {
        if (row.low) paintStem(context, row, scales, at, width, height, opacity);
        mark(context, row.layer, at[0], at[1], opacity, 0.9);
      } else arrowHead(context, row.layer, at[0], at[1], [at[0] - width / 2, at[1] - height / 2], opacity, 0.9);
      if (row.point?.lost) crossOut(context, at[0], at[1], opacity, 0.9);
      if (row.name === picked) ring(context, at[0], at[1]);
    }
  });
  const near = (rows, x, y) =>
    nearestRow(rows.filter(drawn), (row) => placeOf(row, canvas.clientWidth, canvas.clientHeight), x, y);
  let before = null;
  addPointer(canvas, {
    drag: (x0, y0, x, y, done) => {
      before ??= { ...turn };
      turn.azimuth = before.azimuth + (x - x0) * 0.01;
      turn.elevation = Math.min(Math.max(before.elevation + (y - y0) * 0.01, 0), 1.5);
      if (done) before = null;
      view.refresh();
    },
    click: (x, y) => { const row = near(finalists, x, y); if (row) pick(row.name); },
    hover: (x, y) => near(visibleRows(store.get().layers), x, y),
  });
  const turned = (azimuth, elevation) => () => {
    turn.azimuth += azimuth;
    turn.elevation = Math.min(Math.max(turn.elevation + elevation, 0), 1.5);
    view.refresh();
  };
  addKeys(canvas, () => 0, {
    ArrowLeft: turned(-0.15, 0), ArrowRight: turned(0.15, 0), ArrowUp: turned(0, 0.1), ArrowDown: turned(0, -0.1),
  });
}

// A line from a mark down to the floor, so that its place can be read.
function paintStem(context, row, scales, at, width, height, opacity) {
  const floor = projected([scales[0].to(row.values[0]), scales[1].to(row.values[1]), 0], width, height);
  context.globalAlpha = 0.3 * opacity;
  stroke(context, at[0], at[1], floor[0], floor[1], colour(COLOURS[row.layer]));
  context.globalAlpha = 1;
}

// The floor, the upright edges, and three axes on the outline: the floor's near edges and the leftmost upright one.
function paintCube(context, width, height, scales) {
  const place = (corner) => projected(corner, width, height);
  const edge = (from, to, style) => stroke(context, ...place(from).slice(0, 2), ...place(to).slice(0, 2), style);
  for (const t of [0, 0.25, 0.5, 0.75, 1]) {
    edge([t, 0, 0], [t, 1, 0], colour("grid"));
    edge([0, t, 0], [1, t, 0], colour("grid"));
  }
  const corners = [[0, 0], [1, 0], [0, 1], [1, 1]];
  for (const [x, y] of corners) edge([x, y, 0], [x, y, 1], colour("grid"));
  const lower = (a, b) => (place(a)[1] > place(b)[1] ? 0 : 1);
  const [y, x] = [lower([0.5, 0, 0], [0.5, 1, 0]), lower([0, 0.5, 0], [1, 0.5, 0])];
  const [u, v] = corners.reduce((best, corner) => (place([...corner, 0])[0] < place([...best, 0])[0] ? corner : best));
  [[[0, y, 0], [1, y, 0]], [[x, 0, 0], [x, 1, 0]], [[u, v, 0], [u, v, 1]]].forEach(([from, to], i) => {
    edge(from, to, colour("muted"));
    paintEnds(context, i, scales[i], place(from), place(to), i < 2, width, height);
  });
}

// Title and both ends of an axis: below an edge of the floor, beside an upright one.
function paintEnds(context, i, scale, from, to, floor, width, height) {
  const out = floor ? [0, 16] : [-24, 0];
  for (const [end, at] of [[0.02, from], [0.98, to]]) {
    const back = at === from ? to : from;
    const spot = [0, 1].map((k) => at[k] + (back[k] - at[k]) * 0.1 + out[k]);
    paintTitle(context, significant(scale.back(end < 0.5 ? 0 : 1), 3), ...spot, 60);
  }
  const middle = [0, 1].map((k) => (from[k] + to[k]) / 2);
  const room = Math.min(190, width / 2 - 12);
  if (!floor) paintTitle(context, axisTitle(objectives[i]), 8, 12, room, "left");
  else paintTitle(context, axisTitle(objectives[i]), middle[0] < width / 2 ? 8 : width - 8, height - 10, room, middle[0] < width / 2 ? "left" : "right");
}
