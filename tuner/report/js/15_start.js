// Wires the page: everything drawn again when the colour scheme changes, and in light colours on paper.

function redraw() {
  palette = {};
  for (const chart of charts) chart.refresh();
}

function print(on) {
  document.documentElement.toggleAttribute("data-print", on);
  hideTip();
  palette = {};
  if (!window.Plotly) return;
  // Paper does not wait: what was out of sight is drawn at once, at the width of the paper.
  for (const chart of charts) {
    chart.paint();
    const { element } = chart;
    if (!element.data) continue;
    window.Plotly.relayout(element, on ? { width: element.clientWidth, height: element.clientHeight } : { autosize: true, width: null, height: null });
  }
}

function startCopies() {
  for (const button of document.querySelectorAll("[data-copy]")) {
    button.addEventListener("click", () => copyText(byId(button.dataset.copy).textContent, button));
  }
  byId("save-tuned")?.addEventListener("click", () => saveGains(data.tuned));
  byId("copy-tuned")?.addEventListener("click", (event) => copyText(data.gains_file, event.currentTarget));
}

startTips();
startControls();
if (finalists.length) {
  startPlane();
  startSpace();
  startMatrix();
  startParallel();
  startFinalists();
  startPoint();
}
startCharts();
startCopies();
window.addEventListener("hashchange", () => { if (linked()) pick(linked()); });
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
window.addEventListener("beforeprint", () => print(true));
window.addEventListener("afterprint", () => print(false));
document.documentElement.dataset.ready = String(Math.round(performance.now()));
if (byId("library").textContent) library();
