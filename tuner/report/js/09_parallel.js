// Parallel coordinates: a line a point, an axis for each objective and, if asked for, each gain. Axes are brushed.

const PART = 0.14;

function startParallel() {
  const axes = () => dimensions.filter(({ kind }) => kind === "objective" || store.get()[`${kind}s`]);
  let start = 0;
  const build = () => {
    const shown = axes();
    const { picked, ranges } = store.get();
    byId("parallel").style.minWidth = `${Math.min(40, 7 * shown.length)}rem`;
    const rows = ORDER.flatMap((layer) => rowsOf(layer, 1500));
    const flown = rows.filter((row) => row.low).sort((a, b) => passes(a, ranges) - passes(b, ranges) || (a.name === picked) - (b.name === picked));
    const lines = [...searchedLines(rows.filter((row) => !row.low), shown), ...flown.flatMap((row) => parallelLine(row, shown))];
    const ticks = shown.map((axis, k) => tickMarks(axis, k, shown.length));
    const bars = shown.flatMap((axis, k) => axisShapes(ranges[axis.index], axis, k));
    const titles = shown.map((axis, k) => ({ x: k, y: 1.06, text: titleOf(axis, shown.length > 4 ? 18 : 30), showarrow: false, yanchor: "bottom", font: { color: colour("muted"), size: 12 } }));
    const bare = { showgrid: false, showticklabels: false, fixedrange: true, zeroline: false };
    return { traces: lines, layout: layoutOf({
      xaxis: { ...bare, range: [-0.32, shown.length - 0.68] }, yaxis: { ...bare, range: [-0.05, 1.42] }, ...selecting, selectdirection: "v",
      shapes: bars, annotations: [...titles, ...ticks.flat()], margin: { l: 4, r: 4, t: 4, b: 4 },
    }) };
  };
  const nearest = () => Math.min(Math.max(Math.round(start), 0), axes().length - 1);
  const found = ({ y }) => {
    const axis = axes()[nearest()];
    return [[axis.index, y.map((place) => valueAt(axis, Math.min(Math.max(place, 0), 1)))]];
  };
  const made = addChart("parallel", [...SEEN, "gains", "limits"], build, (element) => addSelecting(element, found,
    () => store.set({ ranges: withRange(store.get().ranges, axes()[nearest()].index, null) })));
  if (!made) return;
  made.element.addEventListener("pointerdown", (event) => {
    const axis = made.element._fullLayout?.xaxis;
    if (axis) start = axis.p2d(event.clientX - made.element.getBoundingClientRect().left - axis._offset);
  }, { capture: true });
  addKeys(made.element, () => 0);
}

// A title over an axis, in lines that are no longer than an axis is wide.
const titleOf = (axis, width) => {
  const lines = [""];
  for (const word of axisTitle(axis).split(" ")) {
    if (lines.at(-1) && `${lines.at(-1)} ${word}`.length > width) lines.push("");
    lines.push(`${lines.pop()} ${word}`.trim());
  }
  return lines.map(escaped).join("<br>");
};
const heights = (row, shown) => shown.map((axis) => Math.min(Math.max(placeIn(axis, row.values[axis.index]), 0), 1));

// A finalist: a line of its layer, with marks where it is the default, the recommended or the picked point, crossed out where it lost flights.
function parallelLine(row, shown) {
  const { ranges, picked } = store.get();
  const [special, pinned] = [row.layer === "default" || row.layer === "tuned", pinLook(row.name)];
  const bold = row.name === picked || Boolean(pinned);
  const { marker, line } = resolved(data.layers[row.layer]);
  const trace = {
    type: "scatter", mode: special || bold ? "lines+markers" : "lines", x: shown.map((_, k) => k), y: heights(row, shown), meta: { pick: row.name },
    opacity: (passes(row, ranges) ? 1 : 0.12) * (special || bold ? 1 : 0.6), marker: { ...marker, opacity: 1 }, hovertemplate: `${escaped(tellingOf(row).join("\n")).replaceAll("\n", "<br>")}<extra></extra>`,
    line: { ...line, ...(pinned ? resolved(pinned.line) : bold && !special ? { color: colour("ink") } : {}), width: bold ? 3 : special ? 2.2 : 1.2 },
  };
  const cross = { symbol: "x-thin", size: 9, line: { width: 2, color: colour("bad") } };
  const lost = { ...trace, mode: "markers", marker: cross, hoverinfo: "skip", hovertemplate: undefined, meta: { part: "lost" } };
  return row.point.lost ? [trace, lost] : [trace];
}

// What the search tried, as one trace with gaps: thousands of lines.
function searchedLines(rows, shown) {
  if (!rows.length) return [];
  const gap = (values) => [...values, null];
  return [{ type: "scatter", mode: "lines", hoverinfo: "skip", opacity: 0.25, line: { width: 1, color: colour("faint") },
    x: rows.flatMap(() => gap(shown.map((_, k) => k))), y: rows.flatMap((row) => gap(heights(row, shown))) }];
}

function tickMarks(axis, k, count) {
  const last = k === count - 1 && count > 1;
  return [0, 0.25, 0.5, 0.75, 1].map((place) => ({ x: k, y: place, text: significant(valueAt(axis, place), 3), showarrow: false, font: { size: 11, color: colour("muted") },
    xanchor: last ? "left" : "right", xshift: last ? 5 : -5, bgcolor: faded("surface", 0.7), borderpad: 0 }));
}

function axisShapes(range, axis, k) {
  const line = { type: "line", x0: k, x1: k, y0: 0, y1: 1, line: { color: colour("muted"), width: 1.2 }, layer: "below" };
  if (!range) return [line];
  const [y0, y1] = range.map((end) => placeIn(axis, held(end, axis)));
  return [line, { type: "rect", x0: k - PART / 2, x1: k + PART / 2, y0, y1, fillcolor: faded("tuned", 0.25), line: { color: colour("tuned"), width: 1.5 } }];
}
