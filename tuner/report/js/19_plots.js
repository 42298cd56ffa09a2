// Line plots, drawn by Plotly when they come into sight and again when something that they show changes.

const plots = [];

// The library stands in the page as text: reading its five megabytes takes a second, and nobody should wait for it before the
// first views are there. It is loaded as a file of its own, so that the browser reads it beside everything else.
let loading = null;

function library() {
  loading ??= new Promise((resolve) => {
    const address = URL.createObjectURL(new Blob([byId("plotly").textContent], { type: "text/javascript" }));
    const done = () => { URL.revokeObjectURL(address); resolve(window.Plotly); };
    document.head.append(make("script", { src: address, async: true, onload: done }));
  });
  return loading;
}

// The library at once: paper does not wait.
function libraryNow() {
  if (!window.Plotly) document.head.append(make("script", {}, byId("plotly").textContent));
  return window.Plotly;
}

const CONFIG = { responsive: true, displaylogo: false, displayModeBar: false, doubleClick: "reset+autosize" };
const finger = window.matchMedia("(pointer: coarse)").matches;

const axisLook = (title, more = {}) => ({
  title: { text: escaped(title), standoff: 6 }, gridcolor: colour("grid"), linecolor: colour("line"), zeroline: false,
  automargin: true, nticks: 6, ...more,
});

const layoutOf = (x, y, more = {}) => ({
  xaxis: x, yaxis: y, margin: { l: 8, r: 12, t: 8, b: 8 }, showlegend: false, hovermode: "closest", uirevision: "kept",
  paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", dragmode: finger ? false : "zoom",
  font: { color: colour("muted"), size: 12, family: typeface() },
  hoverlabel: { bgcolor: colour("surface"), bordercolor: colour("line"), font: { color: colour("ink"), size: 12 }, align: "left" },
  ...more,
});

// Register a figure under the id of its element. build() -> { traces, layout }, or null where there is nothing to show.
function addPlot(id, keys, build) {
  const element = byId(id);
  if (!element) return;
  const plot = { element, stale: true, seen: false };
  plot.paint = () => {
    const made = build();
    plot.stale = false;
    element.removeAttribute("aria-busy");
    element.closest("figure").classList.toggle("empty", !made);
    if (made) libraryNow().react(element, made.traces, made.layout, CONFIG);
  };
  plot.refresh = () => {
    plot.stale = true;
    element.setAttribute("aria-busy", "true");
    if (plot.seen) library().then(() => requestAnimationFrame(() => { if (plot.stale) plot.paint(); }));
  };
  new IntersectionObserver((entries) => {
    plot.seen = entries[entries.length - 1].isIntersecting;
    if (plot.seen && plot.stale) plot.refresh();
  }, { rootMargin: "200px" }).observe(element);
  store.on(keys, plot.refresh);
  plots.push(plot);
}

// Zooming one figure along x zooms all whose ids begin alike.
function linkAcross(prefix) {
  const mates = plots.filter(({ element }) => element.id.startsWith(prefix));
  let busy = false;
  for (const { element } of mates) {
    element.addEventListener("mouseenter", () => {
      if (element.dataset.linked || !element.on) return;
      element.dataset.linked = "yes";
      element.on("plotly_relayout", (change) => {
        const keys = ["xaxis.range[0]", "xaxis.range[1]", "xaxis.autorange"].filter((key) => key in change);
        if (busy || !keys.length) return;
        busy = true;
        const same = Object.fromEntries(keys.map((key) => [key, change[key]]));
        Promise.all(mates.filter((mate) => mate.element !== element && mate.element.data)
          .map((mate) => libraryNow().relayout(mate.element, same))).finally(() => { busy = false; });
      });
    });
  }
}

const symbolOf = { default: "square-open", tuned: "diamond", front: "circle", finalist: "circle-open" };
