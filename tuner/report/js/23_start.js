// Wires the page: everything drawn again when the colour scheme changes, and in light colours on paper.

function redraw() {
  forgetColours();
  for (const view of views) view.refresh();
  for (const plot of plots) plot.refresh();
}

function print(on) {
  document.documentElement.toggleAttribute("data-print", on);
  hideTip();
  forgetColours();
  for (const view of views) view.paint();
  // Paper does not wait: what was out of sight is drawn at once, at the width of the paper.
  for (const plot of plots) {
    plot.paint();
    const { element } = plot;
    if (on && element.data) libraryNow().relayout(element, { width: element.clientWidth, height: element.clientHeight });
    else if (element.data) libraryNow().relayout(element, { autosize: true, width: null, height: null });
  }
}

function startCopies() {
  for (const button of document.querySelectorAll("[data-copy]")) {
    button.addEventListener("click", () => copyText(byId(button.dataset.copy).textContent, button));
  }
  byId("save-tuned")?.addEventListener("click", () => saveGains(data.tuned));
  byId("copy-tuned")?.addEventListener("click", (event) => copyText(data.gains_file, event.currentTarget));
  for (const button of document.querySelectorAll("[data-shows]")) {
    button.addEventListener("click", () => { pick(button.dataset.shows); byId("point").scrollIntoView(); });
  }
}

startTips();
startControls();
startPlane();
startSpace();
startMatrix();
startParallel();
startFinalists();
startPoint();
startResponses();
startLoops();
startTrust();
startCopies();
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
window.addEventListener("beforeprint", () => print(true));
window.addEventListener("afterprint", () => print(false));
document.documentElement.dataset.ready = String(Math.round(performance.now()));
(window.requestIdleCallback ?? setTimeout)(library);
