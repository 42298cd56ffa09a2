// Slices: one gain against one objective or limited quantity, of everything that was flown; limits and names in planes.

function startSlices() {
  const build = () => {
    const { slice, against } = store.get();
    const [gain, quantity] = [dimensions[slice], dimensions[against]];
    const traces = ORDER.flatMap((layer) => layerTraces(layer, slice, against, {}, 0.9, everyRow(layer)));
    const look = { xaxis: { ...spanLook(padded(gain)), title: { text: escaped(axisTitle(gain)) } }, yaxis: { ...spanLook(quantity), title: { text: escaped(axisTitle(quantity)) } } };
    const shapes = [...limitShapes(slice, against), ...outside(gain).map((end) => shade("x", ...end)), ...rangeShapes(slice, against, {})];
    return { traces, layout: layoutOf({ ...look, ...selecting, shapes, annotations: names(slice, against, true) }) };
  };
  const found = ({ x, y }) => [[store.get().slice, x], [store.get().against, y]];
  const made = addChart("slices", [...SEEN, "slice", "against"], build, (element) => addSelecting(element, found,
    () => store.set({ ranges: withRange(withRange(store.get().ranges, store.get().slice, null), store.get().against, null) })));
  if (made) addKeys(made.element, () => store.get().slice);
}

// Candidates are shown here whatever the switches of the plane say: they are what a slice consists of.
const everyRow = (layer) => (finalLayers.includes(layer) ? finalists : candidates()).filter((row) => row.layer === layer);
const finalLayers = ["finalist", "front", "default", "tuned"];

// An axis with a little more than the search range, and the parts of it outside the range.
const AIR = 0.03;
const padded = (gain) => ({ ...gain, low: valueAt(gain, -AIR), high: valueAt(gain, 1 + AIR) });
const outside = (gain) => [[valueAt(gain, -AIR), gain.low], [gain.high, valueAt(gain, 1 + AIR)]];

// A part of an axis that the study forbids, across the whole panel.
function shade(axis, from, to) {
  const other = axis === "x" ? "y" : "x";
  return { type: "rect", [`${axis}0`]: from, [`${axis}1`]: to, [`${other}ref`]: "paper", [`${other}0`]: 0, [`${other}1`]: 1,
    layer: "below", fillcolor: faded("bad", 0.12), line: { width: 0 } };
}

// Beyond the limit, on axes of limited quantities.
const limitShapes = (i, j) => [["x", dimensions[i]], ["y", dimensions[j]]].filter(([, { limit }]) => limit !== undefined)
  .map(([axis, { low, high, limit, sense }]) => (sense === "min" ? shade(axis, low, Math.max(low, limit)) : shade(axis, Math.min(high, limit), high)));

// Names beside the marks that matter, or beside all that have words.
function names(i, j, all = false) {
  const { picked } = store.get();
  const place = (d, row) => warped(held(row.values[d], dimensions[d]), dimensions[d].log);
  const matters = (row) => row.name === picked || pinLook(row.name) || (all && row.point.title !== row.name) || (["default", "tuned"].includes(row.layer) && shownLayer(row.layer));
  const taken = [];
  const width = Math.max(byId(all ? "slices" : "plane").clientWidth - 60, 200);
  return finalists.filter((row) => matters(row) && [i, j].every((d) => isNumber(row.values[d]))).map((row) => {
    const at = width * placeIn(dimensions[i], held(row.values[i], dimensions[i]));
    // The code alone where a phone has no room for the words on either side.
    const text = 7 * row.point.title.length > Math.max(at, width - at) ? row.name : row.point.title;
    const right = at + 7 * text.length > width;
    return { x: place(i, row), y: place(j, row), text: escaped(text), showarrow: false, xanchor: right ? "right" : "left", yanchor: "bottom",
      xshift: right ? -10 : 10, yshift: freeShift(taken, at, 260 * placeIn(dimensions[j], row.values[j]), 7 * text.length * (right ? -1 : 1)),
      font: { color: resolved(pinLook(row.name)?.line.color ?? (["default", "tuned"].includes(row.layer) ? `@${row.layer}` : "@ink")), size: 12, weight: 600 } };
  });
}

// A shift upwards that keeps a name at x and y, of some length to the right, off those before it; in pixels of a small panel.
function freeShift(taken, x, y, length) {
  const [begin, end] = [Math.min(x, x + length), Math.max(x, x + length)];
  const clear = (shift) => y + shift < 250 && taken.every((one) => Math.abs(one.at - y - shift) > 14 || one.end < begin || one.begin > end);
  const shift = [3, -17, 18, -32, 33, -47, 48].find(clear) ?? 3;
  taken.push({ begin, end, at: y + shift });
  return shift;
}
