// The views of the trade-off: what all share, the plane and the scatter matrix. Every point is a mark of its layer.

// Keys of the state that every view shows.
const SEEN = ["ranges", "off", "picked", "pins"];
const ORDER = ["infeasible", "searched", "finalist", "front", "start", "default", "tuned"];
const axisTitle = ({ name, label, unit }) => (unit ? `${name ?? label} [${unit}]` : name ?? label);
const inSpan = (value, { low, high }) => value >= low && value <= high;
// Where a value lies in a range: 0 at its low end, 1 at its high end, and back.
const warped = (value, log) => (log ? Math.log10(Math.max(value, 1e-300)) : value);
const placeIn = ({ low, high, log }, value) => (warped(value, log) - warped(low, log)) / (warped(high, log) - warped(low, log) || 1);
const valueAt = ({ low, high, log }, place) => {
  const at = warped(low, log) + place * (warped(high, log) - warped(low, log));
  return log ? 10 ** at : at;
};
const held = (value, { low, high }) => Math.min(Math.max(value, low), high);
const shownLayer = (layer) => !store.get().off.includes(layer);

// Visible rows of a layer, thinned where a view could not bear them all.
function rowsOf(layer, most = Infinity) {
  if (!shownLayer(layer)) return [];
  const searched = ["infeasible", "searched", "start"].includes(layer);
  const rows = (searched ? candidates() : finalists).filter((row) => row.layer === layer);
  const step = Math.ceil(rows.length / most);
  return step > 1 ? rows.filter((_, k) => k % step === 0) : rows;
}

// Which way a row lies beyond two axes, as a turn of an arrow head from upright; null within them.
function beyond(row, i, j) {
  const side = (value, { low, high }) => (value > high ? 1 : value < low ? -1 : 0);
  const [dx, dy] = [side(row.values[i], dimensions[i]), side(row.values[j], dimensions[j])];
  return dx || dy ? (Math.atan2(dx, dy) * 180) / Math.PI : null;
}

// The marks of one layer in two dimensions. What was flown on held-out scenarios is drawn wherever it lies, as an arrow head at
// the edge where that is beyond the axes.
function layerTraces(layer, i, j, axes, scale, rowsFrom = rowsOf(layer, scale < 1 ? 600 : 6000)) {
  const { marker } = data.layers[layer];
  const rows = rowsFrom.filter((row) => [i, j].every((k) => isNumber(row.values[k]))
    && (row.low || beyond(row, i, j) === null));
  if (!rows.length) return [];
  const { ranges, picked } = store.get();
  const look = resolved(marker);
  const turns = rows.map((row) => beyond(row, i, j));
  const bright = rows.map((row) => (passes(row, ranges) ? look.opacity : 0.16));
  const trace = {
    type: "scatter", mode: "markers", ...axes, ids: rows.map((row) => row.name), meta: { layer },
    x: rows.map((row) => held(row.values[i], dimensions[i])), y: rows.map((row) => held(row.values[j], dimensions[j])),
    hovertext: rows.map((row) => escaped(tellingOf(row).join("\n")).replaceAll("\n", "<br>")), hovertemplate: "%{hovertext}<extra></extra>",
    marker: { ...look, size: look.size * scale, opacity: bright }, cliponaxis: false,
  };
  if (turns.some((turn) => turn !== null)) {
    trace.marker.symbol = turns.map((turn) => (turn === null ? look.symbol : "arrow"));
    trace.marker.angle = turns.map((turn) => turn ?? 0);
    trace.marker.size = turns.map((turn) => (turn === null ? look.size : 13) * scale);
  }
  const inside = rows.filter((_, k) => turns[k] === null);
  return [...barTraces(layer, inside, i, j, axes), trace, ...crossTraces(rows, i, j, axes, scale), ...ringTraces(rows, picked, i, j, axes, scale), ...pinTraces(rows, i, j, axes, scale)];
}

// Held-out intervals of the objectives; gains have none.
function barTraces(layer, rows, i, j, axes) {
  const flown = rows.filter((row) => row.low && passes(row, store.get().ranges));
  if (!flown.length || !shownLayer("intervals")) return [];
  const bars = (d) => (d < objectives.length ? {
    type: "data", symmetric: false, width: 0, thickness: 1, color: resolved(data.layers[layer].line).color,
    array: flown.map((row) => row.high[d] - row.values[d]), arrayminus: flown.map((row) => row.values[d] - row.low[d]),
  } : { visible: false });
  return [{
    type: "scatter", mode: "markers", ...axes, x: flown.map((row) => row.values[i]), y: flown.map((row) => row.values[j]), opacity: 0.55,
    hoverinfo: "skip", marker: { size: 1, color: "rgba(0,0,0,0)" }, error_x: bars(i), error_y: bars(j), meta: { part: "intervals" },
  }];
}

const overlay = (rows, i, j, axes, marker, meta) => (rows.length ? [{
  type: "scatter", mode: "markers", ...axes, x: rows.map((row) => held(row.values[i], dimensions[i])),
  y: rows.map((row) => held(row.values[j], dimensions[j])), hoverinfo: "skip", marker, meta, cliponaxis: false,
}] : []);

// A cross over each point that lost flights when held out, and a ring around the picked one.
const crossTraces = (rows, i, j, axes, scale) => overlay(rows.filter((row) => row.point?.lost), i, j, axes,
  { symbol: "x-thin", size: 14 * scale, line: { width: 2, color: colour("bad") } }, { part: "lost" });
const ringTraces = (rows, picked, i, j, axes, scale) => overlay(rows.filter((row) => row.name === picked), i, j, axes,
  { symbol: "circle-open", size: 21 * scale, line: { width: 2, color: colour("ink") } }, { part: "ring" });
// The symbol of its pin around each pinned point.
const pinTraces = (rows, i, j, axes, scale) => rows.filter((row) => pinLook(row.name)).flatMap((row) => {
  const { marker } = pinLook(row.name);
  return overlay([row], i, j, axes, { symbol: `${marker.symbol}-open`, size: 19 * scale, color: resolved(marker.color), line: { width: 2.5 } }, { part: "pin" });
});

const spanLook = (dimension) => ({
  ...(dimension.log ? { type: "log", dtick: "D2", range: [dimension.low, dimension.high].map(Math.log10) } : { range: [dimension.low, dimension.high] }),
  fixedrange: true,
});

// What is selected, as a tinted part of a panel with dashed edges.
function rangeShapes(i, j, refs) {
  const { ranges } = store.get();
  if (!ranges[i] && !ranges[j]) return [];
  const ends = (k) => (ranges[k] ?? [-Infinity, Infinity]).map((end) => held(end, dimensions[k]));
  const [[x0, x1], [y0, y1]] = [ends(i), ends(j)];
  return [{ type: "rect", ...refs, x0, x1, y0, y1, layer: "below", fillcolor: faded("tuned", 0.08), line: { color: faded("tuned", 0.7), width: 1, dash: "4px,3px" } }];
}

// Clicks pick, boxes select, double clicks let go. found(range) -> [dimension, [low, high]] pairs.
function addSelecting(element, found, release) {
  addPicking(element);
  element.on("plotly_selected", (event) => {
    if (!event?.range) return;
    const made = found(event.range).reduce((ranges, [d, ends]) => withRange(ranges, d, [...ends].sort((a, b) => a - b)), store.get().ranges);
    store.set({ ranges: made });
  });
  element.on("plotly_doubleclick", release);
}

const selecting = { dragmode: finger ? false : "select", selections: [], newselection: { line: { width: 1 } } };

// Keys on a view: arrows walk along the finalists in the order of a dimension, Escape clears what is selected.
function addKeys(element, dimension, more = {}) {
  const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1, Home: -Infinity, End: Infinity };
  element.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    if (more[event.key]) more[event.key](event);
    else if (event.key.toLowerCase() === "p") togglePin(store.get().picked);
    else if (event.key in steps) pick(neighbour(dimension(), steps[event.key]));
    else if (event.key === "Escape") store.set({ ranges: Object.freeze({}) });
    else return;
    event.preventDefault();
  });
}

// A plane of two dimensions, which two keys of the state name. traces(i, j); across: the axis of the first dimension; shapes(i):
// further shapes; all: whether every point with words is named.
function addPlane(id, keys, traces, { across = (i) => dimensions[i], shapes = () => [], all = false } = {}) {
  const at = () => keys.map((key) => store.get()[key]);
  const look = (dimension) => ({ ...spanLook(dimension), title: { text: escaped(axisTitle(dimension)) } });
  const build = () => {
    const [i, j] = at();
    return { traces: traces(i, j), layout: layoutOf({ xaxis: look(across(i)), yaxis: look(dimensions[j]), ...selecting,
      shapes: [...shapes(i), ...limitShapes(i, j), ...rangeShapes(i, j, {})], annotations: names(i, j, all) }) };
  };
  const made = addChart(id, [...SEEN, ...keys], build, (element) => addSelecting(element, ({ x, y }) => at().map((k, n) => [k, [x, y][n]]),
    () => store.set({ ranges: at().reduce((ranges, k) => withRange(ranges, k, null), store.get().ranges) })));
  if (made) addKeys(made.element, () => at()[0]);
}

function startPlane() {
  addPlane("plane", ["x", "y"], (i, j) => {
    const traces = ORDER.flatMap((layer) => layerTraces(layer, i, j, {}, 1));
    byId("beyond-legend").hidden = !traces.some((trace) => Array.isArray(trace.marker.symbol));
    return objectives.length === 2 && i === 0 && j === 1 ? [...stairs(), ...traces] : traces;
  });
}

// The boundary of what the front of two objectives dominates.
function stairs() {
  const front = finalists.filter((row) => row.point.front).sort((a, b) => a.values[0] - b.values[0]);
  return [{ type: "scatter", mode: "lines", x: front.map((row) => row.values[0]), y: front.map((row) => row.values[1]), hoverinfo: "skip",
    line: { shape: "hv", width: 1.2, dash: "1px,3px", color: colour("front") }, meta: { part: "stairs" } }];
}

function startMatrix() {
  const count = Math.min(objectives.length, 6);
  const cells = [];
  for (let j = 1; j < count; j += 1) for (let i = 0; i < j; i += 1) cells.push([i, j]);
  const [wide, tall] = [1 / (count - 1), 1 / (count - 1)];
  const key = (k) => (k ? String(k + 1) : "");
  const axes = (k) => ({ xaxis: `x${key(k)}`, yaxis: `y${key(k)}` });
  const build = () => {
    const layout = layoutOf({ ...selecting });
    cells.forEach(([i, j], k) => {
      const title = (d) => ({ text: escaped(objectives[d].label), font: { size: 11 } });
      layout[`xaxis${key(k)}`] = axisLook({ ...spanLook(dimensions[i]), anchor: axes(k).yaxis, domain: [i * wide + 0.02, (i + 1) * wide - 0.02],
        nticks: 4, showticklabels: j === count - 1, ...(j === count - 1 ? { title: title(i) } : {}) });
      layout[`yaxis${key(k)}`] = axisLook({ ...spanLook(dimensions[j]), anchor: axes(k).xaxis, domain: [1 - j * tall + 0.02, 1 - (j - 1) * tall - 0.02],
        nticks: 4, showticklabels: i === 0, ...(i === 0 ? { title: title(j) } : {}) });
    });
    layout.shapes = cells.flatMap(([i, j], k) => rangeShapes(i, j, { xref: axes(k).xaxis, yref: axes(k).yaxis }));
    return { traces: cells.flatMap(([i, j], k) => ORDER.flatMap((layer) => layerTraces(layer, i, j, axes(k), 0.7))), layout };
  };
  const of = (range) => cells.flatMap(([i, j], k) => {
    const { xaxis, yaxis } = axes(k);
    return range[xaxis] && range[yaxis] ? [[i, range[xaxis]], [j, range[yaxis]]] : [];
  });
  const made = addChart("matrix", SEEN, build,
    (element) => addSelecting(element, of, () => store.set({ ranges: Object.freeze({}) })));
  if (made) addKeys(made.element, () => 0);
}
