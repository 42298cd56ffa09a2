// Layers, axes, sliders and what is selected, in native controls, so that keys reach them.

const STEPS = 1000;
// A key press moves a slider by this many steps, a fiftieth of its way.
const STRIDE = 20;

function startControls() {
  for (const box of document.querySelectorAll("[data-layer]")) {
    box.addEventListener("change", () => {
      const others = store.get().off.filter((layer) => layer !== box.dataset.layer);
      store.set({ off: Object.freeze(box.checked ? others : [...others, box.dataset.layer]) });
    });
  }
  for (const key of ["x", "y", "slice", "against"]) {
    const choice = byId(`axis-${key}`);
    choice?.addEventListener("change", () => store.set({ [key]: Number(choice.value) }));
  }
  for (const key of ["scenario", "channel", "airframe"]) {
    const choice = byId(`choose-${key}`);
    choice?.addEventListener("change", () => store.set({ [key === "airframe" ? "picked" : key]: choice.value }));
  }
  byId("behind")?.addEventListener("change", (event) => store.set({ behind: event.target.checked }));
  for (const key of ["gains", "limits"]) byId(`with-${key}`)?.addEventListener("change", (event) => store.set({ [key]: event.target.checked }));
  byId("clear")?.addEventListener("click", () => store.set({ ranges: Object.freeze({}) }));
  startLevels();
  store.on(["ranges"], showSelection);
  showSelection();
}

// A slider for each objective and each limited quantity; at its far end there is no limit.
function startLevels() {
  for (const dimension of dimensions) {
    const holder = byId(dimension.kind === "limit" ? "limit-levels" : "levels");
    if (holder && dimension.kind !== "gain") holder.append(levelRow(dimension));
  }
}

function levelRow(entry) {
  const id = `level-${entry.index}`;
  // Where large values are good, the left end is the one without a limit.
  const [end, free, off] = entry.sense === "min" ? [0, -Infinity, 0] : [1, Infinity, STEPS];
  const slider = make("input", { type: "range", min: 0, max: STEPS, step: STRIDE, value: off, id, class: "level" });
  const shown = make("output", { for: id, class: "number" });
  slider.addEventListener("input", () => {
    const level = Number(slider.value) === off ? free : valueAt(entry, Number(slider.value) / STEPS);
    store.set({ ranges: withLevel(store.get().ranges, entry.index, end, level) });
  });
  const refresh = () => {
    const level = store.get().ranges[entry.index]?.[end] ?? free;
    const text = level === free ? "no limit" : `${end ? "max" : "min"} ${withUnit(significant(level, 3), entry.unit)}`;
    if (document.activeElement !== slider || level === free) {
      slider.value = level === free ? off : Math.round(held(STEPS * placeIn(entry, level), { low: 0, high: STEPS }));
    }
    shown.textContent = text;
    slider.setAttribute("aria-valuetext", text);
  };
  store.on(["ranges"], refresh);
  refresh();
  return make("div", { class: "level-row" }, make("label", { for: id }, term(entry.label, entry.definition)), slider, shown);
}

// The intervals selected, each with a button that lets go of it, and how many points are left.
function showSelection() {
  const holder = byId("selection");
  if (!holder) return;
  const { ranges } = store.get();
  const chips = Object.entries(ranges).map(([i, range]) => make("button", {
    type: "button", class: "chip", title: "Remove this",
    onclick: () => store.set({ ranges: withRange(store.get().ranges, i, null) }),
  }, rangeText(range, dimensions[i]), " ×"));
  byId("chips").replaceChildren(...chips);
  byId("clear").hidden = !chips.length;
  const kept = finalists.filter((row) => row.layer !== "default" && passes(row, ranges));
  const all = finalists.filter((row) => row.layer !== "default");
  byId("count").textContent = countText(kept, all, ranges);
}

function countText(kept, all, ranges) {
  if (!Object.keys(ranges).length) return `All ${all.length} finalists are selected.`;
  if (kept.length) return `${kept.length} of ${all.length} finalists ${kept.length === 1 ? "is" : "are"} selected.`;
  const closest = nearest(all, ranges, dimensions);
  return closest ? `No finalist satisfies all of this; nearest: ${wordsOf(closest.name)}.` : "There are no finalists.";
}
