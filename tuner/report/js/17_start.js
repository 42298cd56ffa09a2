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

// On a phone all sections but the first are folded away, until they are asked for by their heading or by a link.
function startFolds() {
  const folds = [...document.querySelectorAll("section > .fold")];
  if (window.matchMedia("(max-width: 44rem)").matches) for (const fold of folds.slice(1)) fold.open = false;
  const unfold = (hash) => {
    const target = hash.length > 1 && byId(decodeURIComponent(hash.slice(1)));
    for (const fold of folds) if (target && (fold.contains(target) || fold.parentElement === target)) fold.open = true;
  };
  document.addEventListener("click", (event) => unfold(event.target.closest?.("a[href^='#']")?.hash ?? ""));
  window.addEventListener("beforeprint", () => { for (const fold of folds) fold.open = true; });
  if (!linked().picked) unfold(window.location.hash);
}

function startCopies() {
  for (const button of document.querySelectorAll("[data-copy]")) {
    button.addEventListener("click", () => copyText(byId(button.dataset.copy).textContent, button));
  }
  byId("save-tuned")?.addEventListener("click", () => saveGains(data.tuned));
  byId("copy-tuned")?.addEventListener("click", (event) => copyText(data.gains_file, event.currentTarget));
}

startFolds();
startTips();
startControls();
if (finalists.length) {
  startPlane();
  startSpace();
  startMatrix();
  startParallel();
  startSlices();
  startFinalists();
  startPoint();
  startPins();
}
startCharts();
startCopies();
window.addEventListener("hashchange", () => {
  const { picked, pins } = linked();
  if (!picked) return;
  store.set({ pins });
  pick(picked);
});
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
window.addEventListener("beforeprint", () => print(true));
window.addEventListener("afterprint", () => print(false));
document.documentElement.dataset.ready = String(Math.round(performance.now()));
// The still drawing and the tables are painted first: the library holds the page up for a second.
if (byId("library").textContent) requestAnimationFrame(() => setTimeout(library));
