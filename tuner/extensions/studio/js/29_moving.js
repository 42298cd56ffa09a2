// While the hand moves, the lines of the setting at hand are moved in the charts that are drawn already: their axes stay, and a tenth
// of the time is enough. Once it rests, the charts are drawn in full.

const pathOf = (xs, ys, { xaxis, yaxis }) => {
  let path = "";
  for (let i = 0; i < xs.length; i += 1) {
    const [x, y] = [xaxis.d2p(xs[i]), yaxis.d2p(ys[i])];
    if (Number.isFinite(x) && Number.isFinite(y)) path += `${path ? "L" : "M"}${x.toFixed(1)},${y.toFixed(1)}`;
  }
  return path;
};

// Move one trace: line, area up to the next trace, which plotly.js keeps with the lower one, and marks; bars at marks are hidden until
// the next full drawing.
function moveTrace(group, trace, next, axes) {
  group.querySelector(".js-line")?.setAttribute("d", pathOf(trace.x, trace.y, axes));
  if (next?.fill === "tonexty") {
    const back = pathOf([...trace.x].reverse(), [...trace.y].reverse(), axes).replace("M", "L");
    group.querySelector(".js-fill")?.setAttribute("d", `${pathOf(next.x, next.y, axes)}${back}Z`);
  }
  group.querySelectorAll(".points path").forEach((mark, i) => {
    const [x, y] = [axes.xaxis.d2p(trace.x[i]), axes.yaxis.d2p(trace.y[i])];
    if (Number.isFinite(x) && Number.isFinite(y)) mark.setAttribute("transform", `translate(${x},${y})`);
  });
  for (const bars of group.querySelectorAll(".errorbar")) bars.style.display = "none";
}

// Whether a chart could be moved to an answer: it is drawn, and has the same traces.
function moveChart({ element, id }) {
  const made = stored(id);
  const groups = [...element.querySelectorAll(".scatterlayer > .trace")];
  if (!made || !element._fullLayout || element.data?.length !== made.traces.length) return false;
  for (const group of groups) {
    const k = group.__data__?.[0]?.trace?.index;
    if (k === undefined) return false;
    if (made.traces[k].meta?.layer === "here") moveTrace(group, made.traces[k], made.traces[k + 1], element._fullLayout);
  }
  return true;
}

function moveCharts() {
  for (const chart of charts) {
    if (chart.seen && !chart.stale && !moveChart(chart)) chart.refresh();
    else if (!chart.seen) chart.stale = true;
  }
}
