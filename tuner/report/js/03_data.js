// The data of the page, see explorer_data.py; a page without an explorer has charts and arrays alone.

const data = JSON.parse(byId("data").textContent);
const objectives = data.objectives ?? [];
const variables = data.variables ?? [];
// Dimensions of the explorer: objectives in shown units, gains, then limited quantities.
const dimensions = [
  ...objectives.map((entry) => ({ ...entry, kind: "objective", name: entry.label })),
  ...variables.map((entry) => ({ ...entry, kind: "gain", definition: entry.meaning })),
  ...(data.limits ?? []).map((entry) => ({ ...entry, kind: "limit", name: entry.label })),
].map((entry, index) => ({ ...entry, index }));

function bytesOf(packed) {
  const text = atob(packed);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i += 1) bytes[i] = text.charCodeAt(i);
  return bytes.buffer;
}

const singles = (packed) => Array.from(new Float32Array(bytesOf(packed)));
const decoded = new Map();

// An array by its name: single precision, sixteen bits (low + step * q), or a list as it stands.
function arrayOf(name) {
  if (!decoded.has(name)) {
    const stored = data.arrays[name];
    if (typeof stored === "string") decoded.set(name, singles(stored));
    else if (Array.isArray(stored)) decoded.set(name, stored);
    else decoded.set(name, Array.from(new Uint16Array(bytesOf(stored.packed)), (q) => stored.scale[0] + stored.scale[1] * q));
  }
  return decoded.get(name);
}

const layerOf = (point) => point.role || (point.front ? "front" : "finalist");

// What is drawn: name, layer, values along all dimensions, intervals of the objectives, and the point with its texts.
const finalists = (data.points ?? []).map((point) => ({
  name: point.name,
  layer: layerOf(point),
  values: [...point.held_out, ...point.gains, ...point.limited],
  low: point.low,
  high: point.high,
  point,
}));
const byName = new Map(finalists.map((row) => [row.name, row]));
// A point in words, "tuned gains (p0101)".
const wordsOf = (name) => byName.get(name)?.point.title ?? name;
const heading = (name) => wordsOf(name).replace(/^[a-z](?=.* )/, (letter) => letter.toUpperCase());

let candidateRows = null;

// What the search tried beside the finalists, at search values; NaN for limits on flights. Unpacked when it is first asked for.
function candidates() {
  if (candidateRows) return candidateRows;
  const { number, state, values } = data.candidates;
  const numbers = new Uint32Array(bytesOf(number));
  const states = new Uint8Array(bytesOf(state));
  const columns = values.map(singles);
  candidateRows = Array.from(numbers, (candidate, i) => ({
    name: `candidate ${candidate}`,
    layer: ["infeasible", "searched", "start"][states[i]],
    values: columns.map((column) => column[i]),
  }));
  return candidateRows;
}
