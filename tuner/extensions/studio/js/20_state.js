// The setting at hand: values of the gains, pins, scenario and loop; its history, and the address that holds it.

const studio = { study: null, values: {}, pins: [], scenario: 0, channel: "" };
const MAX_HISTORY = 200;
const history = { states: [], at: -1 };

const gainOf = (name) => studio.study.gains.find((gain) => gain.name === name);
const snapshot = () => JSON.stringify({ values: studio.values, pins: studio.pins, scenario: studio.scenario, channel: studio.channel });

// Note the present state, unless it is the one noted last; states that were undone are dropped.
function remember() {
  const now = snapshot();
  if (history.states[history.at] === now) return;
  history.states = [...history.states.slice(0, history.at + 1), now].slice(-MAX_HISTORY);
  history.at = history.states.length - 1;
  window.history.replaceState(null, "", `#${encoded()}`);
  showHistory();
}

function travel(places) {
  const at = history.at + places;
  if (at < 0 || at >= history.states.length) return;
  history.at = at;
  Object.assign(studio, JSON.parse(history.states[at]));
  window.history.replaceState(null, "", `#${encoded()}`);
  showAll();
  request();
}

// The state as text of the address: values in the order of the study's gains, so that it stays short.
const listed = (values) => studio.study.gains.map((gain) => String(values[gain.name])).join(",");

function encoded() {
  const parts = new URLSearchParams({ at: listed(studio.values), scenario: String(studio.scenario), loop: studio.channel });
  for (const pin of studio.pins) parts.append("pin", `${listed(pin.values)};${pin.name}`);
  return parts.toString();
}

// Values by name from a list of the address; null where it does not fit the study.
function unlisted(text) {
  const numbers = text.split(",").map(Number);
  if (numbers.length !== studio.study.gains.length || !numbers.every(Number.isFinite)) return null;
  return Object.fromEntries(studio.study.gains.map((gain, i) => [gain.name, numbers[i]]));
}

// Take the state of an address over; parts that do not fit are left as they are.
function decode(hash) {
  const parts = new URLSearchParams(hash.replace(/^#/, ""));
  const values = unlisted(parts.get("at") ?? "");
  if (values) studio.values = values;
  const scenario = Number(parts.get("scenario") ?? 0);
  if (studio.study.scenarios[scenario] !== undefined) studio.scenario = scenario;
  if (studio.study.channels.includes(parts.get("loop"))) studio.channel = parts.get("loop");
  const pins = parts.getAll("pin").slice(0, MAX_PINS).map((text) => {
    const [list, ...name] = text.split(";");
    return { name: name.join(";").slice(0, MAX_NAME), values: unlisted(list) };
  });
  if (values) studio.pins = pins.filter((pin) => pin.values);
}
