// Whether to believe it: search against held-out values, places on the front, and how the search went.

function startTrust() {
  objectives.forEach((_, i) => addPlot(`gap-${i}`, ["picked", "ranges"], () => gapFigure(i)));
  addPlot("probability", ["picked"], probabilityFigure);
  addPlot("progress-hypervolume", [], () => progressFigure("hypervolume", "tuned", "circle", 1));
  addPlot("progress-feasible", [], () => progressFigure("feasible_share", "front", "square", 100, [-4, 104]));
  addPlot("progress-saved", [], savedFigure);
}

// Held-out over search values of every finalist; on the line they agree.
function gapFigure(i) {
  const { picked, ranges } = store.get();
  const rows = finalists.filter((row) => isNumber(row.point.search[i]) && isNumber(row.values[i]))
    .sort((a, b) => (a.name === picked) - (b.name === picked));
  if (!rows.length) return null;
  const factor = objectives[i].factor;
  const x = rows.map((row) => row.point.search[i] * factor);
  const y = rows.map((row) => row.values[i]);
  // What is shown of the axes elsewhere, and the search values of what lies there: failed flights are decades away.
  const seen = x.filter((_, k) => y[k] >= objectives[i].low && y[k] <= objectives[i].high);
  const reach = [Math.min(...seen, objectives[i].low), Math.max(...seen, objectives[i].high)];
  const unit = objectives[i].unit;
  const traces = [
    { type: "scatter", mode: "lines", x: reach, y: reach, hoverinfo: "skip", line: { color: colour("muted"), width: 1, dash: "dot" } },
    {
      type: "scatter", mode: "markers", x, y,
      marker: {
        symbol: rows.map((row) => symbolOf[row.layer]), size: rows.map((row) => (row.name === picked ? 13 : 8)),
        color: rows.map((row) => colour(COLOURS[row.layer])), opacity: rows.map((row) => (passes(row, ranges) ? 1 : 0.2)),
        line: { width: rows.map((row) => (row.name === picked ? 2.5 : 1)), color: rows.map((row) => colour(row.name === picked ? "ink" : COLOURS[row.layer])) },
      },
      error_y: {
        type: "data", symmetric: false, array: rows.map((row) => row.high[i] - row.values[i]),
        arrayminus: rows.map((row) => row.values[i] - row.low[i]), width: 0, thickness: 1, color: faded("muted", 0.6),
      },
      text: rows.map((row) => escaped(row.name)),
      hovertemplate: `%{text}: search %{x:.4~g}, held-out %{y:.4~g} ${escaped(unit)}<extra></extra>`,
    },
  ];
  const log = objectives[i].log && reach[0] > 0
    ? { type: "log", dtick: "D2", range: reach.map(Math.log10) } : { range: reach };
  return { traces, layout: layoutOf(axisLook(axisTitle({ name: "search", unit }), log), axisLook(axisTitle({ name: "held-out", unit }), log)) };
}

function probabilityFigure() {
  const rows = finalists.filter((row) => row.layer !== "default" && isNumber(row.point.probability))
    .sort((a, b) => b.point.probability - a.point.probability);
  if (!rows.length) return null;
  const { picked } = store.get();
  const trace = {
    type: "bar", x: rows.map((_, k) => k + 1), y: rows.map((row) => 100 * row.point.probability), text: rows.map((row) => escaped(row.name)),
    textposition: "none", hovertemplate: "%{text}: %{y:.0f} %<extra></extra>",
    marker: {
      color: rows.map((row) => faded(row.layer === "tuned" ? "tuned" : "front", 0.55)),
      line: { color: rows.map((row) => colour(row.name === picked ? "ink" : "surface")), width: rows.map((row) => (row.name === picked ? 2 : 0.5)) },
    },
  };
  return { traces: [trace], layout: layoutOf(axisLook("finalists, surest first"), axisLook("non-dominated [%]", { range: [0, 104] })) };
}

function progressFigure(name, ink, symbol, factor, range) {
  const { generation, flights } = data.history;
  const trace = {
    type: "scatter", mode: "lines+markers", x: generation, y: data.history[name].map((value) => value * factor),
    line: { width: 1.8, color: colour(ink) }, marker: { size: 5, symbol, color: colour(ink) }, text: flights.map((count) => fixed(count, 0)),
    hovertemplate: "%{y:.4~g} after %{text} flights<extra></extra>",
  };
  return { traces: [trace], layout: layoutOf(axisLook("generation"), axisLook("", range ? { range } : {})) };
}

// Flights made and, on top of them, those that screening and racing saved; all cumulative.
function savedFigure() {
  const { generation, flights, flights_saved: screened, flights_raced: raced } = data.history;
  if (!screened && !raced) return null;
  const layers = [["flown", flights, "tuned", ""], ["saved by racing", raced, "front", "/"], ["saved by screening", screened, "default", "x"]];
  const traces = layers.filter(([, counts]) => counts).map(([name, counts, ink, shape]) => ({
    type: "bar", x: generation, y: counts, name, hovertemplate: `${name}: %{y:,.0f}<extra></extra>`,
    marker: { color: faded(ink, 0.6), pattern: { shape, fgcolor: colour(ink), size: 5, solidity: 0.25 } },
  }));
  const legend = { orientation: "h", y: 1.15, x: 0, font: { size: 11 } };
  return { traces, layout: layoutOf(axisLook("generation"), axisLook("flights, cumulative"), { barmode: "stack", showlegend: true, legend }) };
}
