// Slices: one gain against one objective or limited quantity, of everything that was flown; limits and names in planes.

// An axis has a little more than the search range; what lies outside the range is shaded.
const AIR = 0.03;

function startSlices() {
  const beyondRange = (gain) => [valueAt(gain, -AIR), valueAt(gain, 1 + AIR)];
  // Candidates are shown whatever the switches of the plane say: they are what a slice consists of.
  const everyRow = (layer) => (["infeasible", "searched", "start"].includes(layer) ? candidates() : finalists).filter((row) => row.layer === layer);
  addPlane("slices", ["slice", "against"], (i, j) => ORDER.flatMap((layer) => layerTraces(layer, i, j, {}, 0.9, everyRow(layer))), {
    across: (i) => ({ ...dimensions[i], low: beyondRange(dimensions[i])[0], high: beyondRange(dimensions[i])[1] }),
    shapes: (i) => [shade("x", beyondRange(dimensions[i])[0], dimensions[i].low), shade("x", dimensions[i].high, beyondRange(dimensions[i])[1])],
    all: true,
  });
}

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
