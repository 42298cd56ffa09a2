"use strict";
// Draws the charts of a report from the JSON beside it, in the reader's light or dark colours, and redraws when those change.
const data = JSON.parse(document.getElementById("chart-data").textContent);
const dark = window.matchMedia("(prefers-color-scheme: dark)");
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
const config = { displaylogo: false, responsive: true, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };

function layout(extra) {
  const axis = { gridcolor: colour("line"), zerolinecolor: colour("line"), linecolor: colour("line"), automargin: true };
  const base = { paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: colour("ink"), size: 13,
    family: "system-ui, sans-serif" }, margin: { l: 56, r: 12, t: 12, b: 44 }, legend: { orientation: "h", y: 1.12 },
    hoverlabel: { align: "left" } };
  const merged = Object.assign(base, extra);
  for (const name of ["xaxis", "yaxis"]) merged[name] = Object.assign({}, axis, merged[name] || {});
  return merged;
}

function objectiveAxis(i) {
  const o = data.objectives[i];
  const log = o.scale === "log";
  return { title: { text: o.axis }, type: o.scale, range: log ? [Math.log10(o.low), Math.log10(o.high)] : [o.low, o.high],
    dtick: log ? "D2" : undefined };
}

const STYLES = [
  { pick: (p) => p.role === "" && p.best, name: "front, held-out with 95 % interval", symbol: "circle", ink: "blue", size: 8 },
  { pick: (p) => p.role === "" && !p.best, name: "finalist, not on the held-out front", symbol: "circle-open", ink: "grey", size: 8 },
  { pick: (p) => p.role === "default", name: "default", symbol: "diamond", ink: "orange", size: 12 },
  { pick: (p) => p.role === "tuned", name: "tuned", symbol: "star", ink: "green", size: 16 },
];

function hover(p) {
  const values = data.objectives.map((o, i) => `${o.axis}: ${p.value[i]} (search ${p.search[i]})`);
  return [`<b>${p.name}</b> ${p.role}`, ...values, ...p.gains].join("<br>");
}

function bars(points, i) {
  return { type: "data", symmetric: false, thickness: 1, width: 2, array: points.map((p) => p.high[i] - p.value[i]),
    arrayminus: points.map((p) => p.value[i] - p.low[i]) };
}

function tried(i, j) {
  const groups = [[false, "tried, breaks a constraint", "x-thin-open"], [true, "tried, search value", "circle"]];
  return groups.map(([feasible, name, symbol]) => {
    const keep = data.candidates.feasible.map((f, k) => (f === feasible ? k : -1)).filter((k) => k >= 0);
    return { x: keep.map((k) => data.candidates.values[i][k]), y: keep.map((k) => data.candidates.values[j][k]), name,
      mode: "markers", type: "scatter", hoverinfo: "skip", visible: feasible ? true : "legendonly",
      marker: { symbol, size: 4, color: colour("grey"), opacity: 0.55 } };
  });
}

function drawPair(element, i, j) {
  const traces = tried(i, j);
  for (const style of STYLES) {
    const points = data.front.filter(style.pick);
    if (!points.length) continue;
    traces.push({ x: points.map((p) => p.value[i]), y: points.map((p) => p.value[j]), error_x: bars(points, i),
      error_y: bars(points, j), text: points.map(hover), hovertemplate: "%{text}<extra></extra>", name: style.name,
      mode: "markers", type: "scatter", marker: { symbol: style.symbol, size: style.size, color: colour(style.ink) } });
  }
  Plotly.react(element, traces, layout({ xaxis: objectiveAxis(i), yaxis: objectiveAxis(j), margin: { l: 64, r: 12, t: 40, b: 48 } }), config);
}

function drawOne(element) {
  const points = data.front;
  Plotly.react(element, [{ x: points.map((p) => p.name), y: points.map((p) => p.value[0]), error_y: bars(points, 0),
    text: points.map(hover), hovertemplate: "%{text}<extra></extra>", mode: "markers", type: "scatter",
    marker: { size: 10, color: colour("blue") } }], layout({ yaxis: { title: { text: data.objectives[0].axis } } }), config);
}

function drawSpace(element) {
  const traces = STYLES.map((style) => {
    const points = data.front.filter(style.pick);
    return { x: points.map((p) => p.value[0]), y: points.map((p) => p.value[1]), z: points.map((p) => p.value[2]), name: style.name,
      text: points.map(hover), hovertemplate: "%{text}<extra></extra>", mode: "markers", type: "scatter3d",
      marker: { size: style.size / 2, color: colour(style.ink), symbol: style.symbol === "star" ? "cross" : style.symbol } };
  });
  const axis = (i) => ({ title: { text: data.objectives[i].axis }, type: data.objectives[i].scale, gridcolor: colour("line") });
  Plotly.react(element, traces, layout({ scene: { xaxis: axis(0), yaxis: axis(1), zaxis: axis(2) } }), config);
}

function drawParallel(element) {
  const points = data.front;
  const rank = points.map((p) => (p.role === "tuned" ? 1 : p.role === "default" ? 0.5 : 0));
  Plotly.react(element, [{ type: "parcoords", dimensions: data.objectives.map((o, i) => ({ label: o.axis, values: points.map((p) => p.value[i]) })),
    line: { color: rank, colorscale: [[0, colour("grey")], [0.5, colour("orange")], [1, colour("green")]] } }],
    layout({ margin: { l: 80, r: 80, t: 60, b: 30 } }), config);
}

function drawHistory(element) {
  const h = data.history;
  const line = (y, name, ink, dash, symbol) => ({ x: h.flights, y, name, mode: "lines+markers", type: "scatter",
    line: { color: colour(ink), dash }, marker: { symbol, size: 6 } });
  Plotly.react(element, [line(h.hypervolume, "hypervolume", "blue", "solid", "circle"), line(h.feasible, "feasible share", "orange", "dash", "square")],
    layout({ xaxis: { title: { text: "flights" } }, yaxis: { title: { text: "share" }, range: [0, 1.05] }, margin: { l: 56, r: 12, t: 40, b: 44 } }), config);
}

function fanTraces(fan, ink, dash, label) {
  const line = (y, more) => Object.assign({ x: fan.time, y, type: "scatter", mode: "lines", hoverinfo: "skip", showlegend: false }, more);
  return [line(fan.high, { line: { width: 0, color: colour(ink) } }),
    line(fan.low, { line: { width: 0, color: colour(ink) }, fill: "tonexty", fillcolor: colour(ink) + "33" }),
    line(fan.median, { line: { width: 2, color: colour(ink), dash }, name: label, hoverinfo: "x+y+name" })];
}

function drawResponses() {
  const scenario = document.getElementById("scenario").value;
  const chosen = document.getElementById("point").value;
  const find = (point, signal) => data.fans.find((f) => f.point === point && f.scenario === scenario && f.signal === signal);
  for (const element of document.querySelectorAll("[data-signal]")) {
    const signal = element.dataset.signal;
    const [base, fan] = [find("default", signal), find(chosen, signal)];
    const traces = [];
    if (base && chosen !== "default") traces.push(...fanTraces(base, "orange", "dash", "default"));
    if (fan) traces.push(...fanTraces(fan, chosen === "default" ? "orange" : "blue", chosen === "default" ? "dash" : "solid", chosen));
    if (fan && ["x", "y", "z", "yaw"].includes(signal)) traces.push({ x: fan.time, y: fan.reference, mode: "lines", type: "scatter",
      name: "reference", hoverinfo: "skip", showlegend: false, line: { color: colour("ink"), width: 1, dash: "dot" } });
    Plotly.react(element, traces, layout({ xaxis: { title: { text: "time [s]", standoff: 4 } }, yaxis: { title: { text: (fan || base).axis } },
      margin: { l: 52, r: 8, t: 8, b: 38 } }), Object.assign({}, config, { displayModeBar: false }));
  }
}

function drawAll() {
  for (const element of document.querySelectorAll("[data-pair]")) drawPair(element, ...element.dataset.pair.split(",").map(Number));
  const drawings = { "front-one": drawOne, "front-space": drawSpace, "front-parallel": drawParallel, history: drawHistory };
  for (const [id, draw] of Object.entries(drawings)) { const element = document.getElementById(id); if (element) draw(element); }
  if (data.fans.length) drawResponses();
}

for (const id of ["point", "scenario"]) document.getElementById(id)?.addEventListener("change", drawResponses);
document.getElementById("copy")?.addEventListener("click", (event) => {
  navigator.clipboard.writeText(document.getElementById("gains-json").textContent).then(() => { event.target.textContent = "Copied"; });
});
dark.addEventListener("change", drawAll);
drawAll();
