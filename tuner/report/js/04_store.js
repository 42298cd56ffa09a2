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

// picked: name of a finalist. ranges: what is selected, dimension -> [low, high]. layers: what is shown.
const store = makeStore({
  picked: byName.has(data.tuned) ? data.tuned : finalists[0].name,
  ranges: Object.freeze({}),
  layers: Object.freeze({
    tuned: true, default: true, front: true, finalist: true, start: true, searched: false, infeasible: false, intervals: true,
  }),
  x: 0,
  y: Math.min(1, dimensions.length - 1),
  gains: false,
  scenario: 0,
  channel: 0,
  behind: true,
  order: -1,
});

const pick = (name) => {
  if (!byName.has(name) || name === store.get().picked) return;
  store.set({ picked: name });
  announce(`Picked ${name}: ${summaryOf(byName.get(name)).join(", ")}`);
};

// Name of the finalist so many places further along a dimension, among those that are selected.
function neighbour(dimension, places) {
  const { picked, ranges } = store.get();
  const rows = finalists.filter((row) => passes(row, ranges) || row.name === picked)
    .sort((a, b) => a.values[dimension] - b.values[dimension]);
  const at = rows.findIndex((row) => row.name === picked);
  return rows[Math.min(Math.max(at + places, 0), rows.length - 1)]?.name;
}
