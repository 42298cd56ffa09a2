// Slices: one gain against one objective or limited quantity, of everything that was flown.

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
