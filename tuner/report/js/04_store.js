// The state of the page in one place; views subscribe to the parts that they show.

// A store: get() the state, set() some of its keys, on(keys, listener) to hear of changes of any of them.
function makeStore(initial) {
  let state = Object.freeze(initial);
  const listeners = [];
  return {
    get: () => state,
    set(change) {
      const before = state;
      state = Object.freeze({ ...state, ...change });
      for (const { keys, listener } of listeners) {
        if (keys.some((key) => state[key] !== before[key])) listener(state);
      }
    },
    on(keys, listener) {
      listeners.push({ keys, listener });
    },
  };
}

// Points that the address of the page names, as `#point=p0101&pins=p0103,p0107`: the picked one, or null, and those pinned.
function linked() {
  const parts = new URLSearchParams(window.location.hash.slice(1));
  const pins = (parts.get("pins") ?? "").split(",").filter((name) => byName.has(name) && name !== "default");
  const name = parts.get("point");
  return { picked: byName.has(name) ? name : null, pins: Object.freeze([...new Set(pins)].slice(0, data.pins?.length ?? 0)) };
}

function address() {
  const { picked, pins } = store.get();
  return `#point=${encodeURIComponent(picked)}${pins.length ? `&pins=${pins.map(encodeURIComponent).join(",")}` : ""}`;
}

// picked: name of a finalist, or of an airframe. pins: names of those laid over it. ranges: what is selected, dimension -> [low, high]. off: layers not shown.
const store = makeStore({
  picked: linked().picked ?? (byName.has(data.tuned) ? data.tuned : finalists[0]?.name),
  pins: linked().pins,
  ranges: Object.freeze({}),
  off: Object.freeze([...document.querySelectorAll("[data-layer]:not(:checked)")].map((box) => box.dataset.layer)),
  x: 0,
  y: Math.min(1, dimensions.length - 1),
  slice: objectives.length,
  against: 0,
  gains: false,
  limits: false,
  scenario: byId("choose-scenario")?.value ?? data.responses?.scenarios[0],
  channel: byId("choose-channel")?.value,
  behind: true,
  order: -1,
});

const pick = (name) => {
  if (!byName.has(name) || name === store.get().picked) return;
  store.set({ picked: name });
  window.history.replaceState(null, "", address());
  announce(`Picked ${wordsOf(name)}: ${summaryOf(byName.get(name)).join(", ")}`);
};

// Name of the finalist so many places further along a dimension, among those that are selected.
function neighbour(dimension, places) {
  const { picked, ranges } = store.get();
  const rows = finalists.filter((row) => passes(row, ranges) || row.name === picked)
    .sort((a, b) => a.values[dimension] - b.values[dimension]);
  const at = rows.findIndex((row) => row.name === picked);
  return rows[Math.min(Math.max(at + places, 0), rows.length - 1)]?.name;
}
