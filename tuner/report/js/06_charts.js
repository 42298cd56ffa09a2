// Charts of plotly.js, drawn when they come into sight and again when something that they show changes. Their traces and layouts are
// complete but for two kinds of names (see charts/web.py): "@colour" is resolved against the style sheet, "#array" against the data.

const charts = [];
let palette = {};
let loading = null;

// The library stands in the page compressed; it is unpacked beside everything else, so that nobody waits for it to read the page.
function library() {
  loading ??= (async () => {
    const packed = new Blob([bytesOf(byId("library").textContent)]).stream().pipeThrough(new DecompressionStream("gzip"));
    const source = await new Response(packed).arrayBuffer();
    const address = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
    await new Promise((resolve) => { document.head.append(make("script", { src: address, async: true, onload: resolve })); });
    URL.revokeObjectURL(address);
    return window.Plotly;
  })();
  return loading;
}

function colour(name) {
  palette[name] ??= getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  return palette[name];
}

function faded(name, opacity) {
  return `rgba(${[1, 3, 5].map((i) => parseInt(colour(name).slice(i, i + 2), 16)).join(",")},${opacity})`;
}

function resolved(value) {
  if (typeof value === "string") {
    if (value.startsWith("@")) {
      const [name, opacity] = value.slice(1).split("/");
      return opacity ? faded(name, opacity) : colour(name);
    }
    return value.startsWith("#a") && value.slice(1) in data.arrays ? arrayOf(value.slice(1)) : value;
  }
  if (Array.isArray(value)) return value.map(resolved);
  if (value === null || typeof value !== "object") return value;
  if (value.zip) {
    const columns = value.zip.map((name) => arrayOf(name.slice(1)));
    return columns[0].map((_, i) => columns.map((column) => column[i]));
  }
  return Object.fromEntries(Object.entries(value).map(([key, entry]) => [key, key === "meta" ? entry : resolved(entry)]));
}

const among = (wanted, value) => wanted === undefined || (Array.isArray(wanted) ? wanted.includes(value) : wanted === value);

// Whether a mark is seen: `meta` says for which choices it is.
function visible(meta = {}) {
  const { picked, pins, scenario, channel, behind, off } = store.get();
  if (off.includes(meta.layer) || off.includes(meta.part)) return false;
  if (!among(meta.scenario, scenario ?? meta.scenario) || !among(meta.channel, channel ?? meta.channel)) return false;
  // Of pinned points medians and loops alone are drawn: with five points nobody could follow bands and worst flights.
  return among(meta.point, picked ?? meta.point) || (behind && meta.point === "default") || (pins.includes(meta.point) && !["band", "worst"].includes(meta.part));
}

// The look of a pinned point; undefined of others, and of the picked one, which has its own.
const pinLook = (name) => (name === store.get().picked ? undefined : data.pins?.[store.get().pins.indexOf(name)]);

// A trace of a pinned point in the look of its pin.
function dyed(trace) {
  const look = pinLook(trace.meta?.point);
  if (!look) return trace;
  const made = JSON.parse(JSON.stringify(trace).replaceAll('"@tuned', `"${look.line.color}`));
  if (made.line?.dash === "solid") made.line.dash = look.line.dash;
  if (made.marker?.symbol) made.marker.symbol = look.marker.symbol;
  return made;
}

const CONFIG = { responsive: true, displaylogo: false, displayModeBar: false, doubleClick: "reset+autosize" };
const finger = window.matchMedia("(pointer: coarse)").matches;

const axisLook = (axis = {}) => ({
  gridcolor: colour("grid"), linecolor: colour("line"), zeroline: false, automargin: true, nticks: 6, exponentformat: axis.type === "log" ? "power" : "none", ...axis,
  title: { standoff: 6, ...axis.title },
});

// A layout in the colours and type of the page. One finger scrolls the page; charts are zoomed with a mouse.
function layoutOf({ xaxis, yaxis, ...more }) {
  return {
    xaxis: axisLook(xaxis), yaxis: axisLook(yaxis), margin: { l: 8, r: 12, t: 8, b: 8 }, showlegend: false, hovermode: "closest",
    uirevision: "kept", paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", dragmode: finger ? false : "zoom",
    font: { color: colour("muted"), size: 12, family: getComputedStyle(document.body).fontFamily },
    hoverlabel: { bgcolor: colour("surface"), bordercolor: colour("line"), font: { color: colour("ink"), size: 12 }, align: "left" },
    ...more,
  };
}

// A stored chart as plotly.js takes it, with the picked point and the selection brought out; null where nothing is seen.
function stored(id) {
  const { traces, layout } = data.charts[id];
  const shown = traces.filter((trace) => visible(trace.meta)).map((trace) => emphasised(resolved(dyed(trace))));
  const look = resolved(layout);
  for (const kind of ["shapes", "annotations"]) if (look[kind]) look[kind] = look[kind].filter((one) => visible(one.meta)).map(({ meta, ...one }) => one);
  return shown.length ? { traces: shown, layout: layoutOf(look), hides: look.meta?.hides } : null;
}

// Points with names: those selected stay bright, the picked one is larger and ringed.
function emphasised(trace) {
  if (!trace.ids || !finalists.length) return trace;
  const { picked, ranges } = store.get();
  const { marker } = trace;
  const is = trace.ids.map((name) => name === picked);
  const bright = trace.ids.map((name) => (!byName.has(name) || passes(byName.get(name), ranges) ? 1 : 0.2));
  if (trace.type === "bar") {
    const line = { color: is.map((one) => (one ? colour("ink") : colour("surface"))), width: is.map((one) => (one ? 2 : 0.5)) };
    return { ...trace, text: trace.ids.map((name) => escaped(wordsOf(name))), marker: { ...marker, line } };
  }
  const line = { ...marker.line, width: is.map((one) => (one ? 2.5 : marker.line.width)), color: is.map((one) => (one ? colour("ink") : marker.line.color)) };
  return { ...trace, marker: { ...marker, opacity: bright, size: is.map((one) => marker.size + (one ? 4 : 0)), line } };
}

// Register a chart under the id of its element. build() -> { traces, layout }, or null where there is nothing to show.
function addChart(id, keys, build, drawn) {
  const element = byId(id);
  if (!element) return null;
  const chart = { id, element, stale: true, seen: false };
  const figure = element.closest("figure");
  chart.paint = () => {
    const made = build();
    chart.stale = false;
    element.removeAttribute("aria-busy");
    figure.classList.toggle("empty", !made);
    figure.hidden = !made && Boolean(data.charts[id]?.layout.meta?.hides);
    if (!made) return;
    element.querySelector(".sketch")?.remove();
    window.Plotly.react(element, made.traces, made.layout, CONFIG);
    if (!chart.wired && element.on) { chart.wired = true; drawn?.(element); }
  };
  chart.refresh = () => {
    chart.stale = true;
    element.setAttribute("aria-busy", "true");
    // Drawn while it is visible, because a hidden element has no size.
    if (figure.hidden) { figure.hidden = false; chart.seen = true; }
    if (chart.seen) library().then(() => requestAnimationFrame(() => { if (chart.stale) chart.paint(); }));
  };
  new IntersectionObserver((entries) => {
    chart.seen = entries[entries.length - 1].isIntersecting;
    if (chart.seen && chart.stale) chart.refresh();
  }, { rootMargin: "200px" }).observe(element);
  store.on(keys, chart.refresh);
  charts.push(chart);
  return chart;
}

const STATE = ["picked", "pins", "ranges", "off", "scenario", "channel", "behind"];

// Keys of the state that a stored chart depends on.
function keysOf({ traces }) {
  const named = traces.some((trace) => trace.ids);
  const used = new Set(traces.flatMap(({ meta = {} }) => Object.keys(meta)));
  const asks = { picked: named || used.has("point"), pins: used.has("point"), behind: used.has("point"), ranges: named, off: used.has("layer") || used.has("part"),
    scenario: used.has("scenario"), channel: used.has("channel") };
  return STATE.filter((key) => asks[key]);
}

function startCharts() {
  for (const [id, chart] of Object.entries(data.charts ?? {})) {
    addChart(id, keysOf(chart), () => stored(id), (element) => { linkAcross(element); addPicking(element); });
  }
}

// Zooming one response in time zooms all, and so for the two Bode curves.
let linking = false;
function linkAcross(element) {
  const prefix = ["response-", "loop-"].find((name) => element.id.startsWith(name) && element.id !== "loop-nyquist");
  if (!prefix) return;
  element.on("plotly_relayout", (change) => {
    const same = Object.fromEntries(Object.entries(change).filter(([key]) => /^xaxis\.(range\[[01]\]|autorange)$/.test(key)));
    if (linking || !Object.keys(same).length) return;
    linking = true;
    const mates = charts.filter((mate) => mate.element !== element && mate.element.data && mate.id.startsWith(prefix) && mate.id !== "loop-nyquist");
    Promise.all(mates.map((mate) => window.Plotly.relayout(mate.element, same))).finally(() => { linking = false; });
  });
}

// A click on a mark picks its point, and with Shift pins it.
function addPicking(element) {
  element.on("plotly_click", ({ points, event }) => {
    const name = points.map((point) => point.id ?? point.data.meta?.pick).find((id) => byName.has(id));
    if (name) (event?.shiftKey ? togglePin : pick)(name);
  });
}
