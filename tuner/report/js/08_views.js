// What the views on canvases share: they draw when they come into sight and again when something that they show changes.

const views = [];

// Register a view: drawn by paint(context, width, height), again after changes of `keys` of the store.
function addView(canvas, keys, paint) {
  const view = { canvas, stale: true, seen: false, waiting: false };
  view.paint = () => {
    view.waiting = false;
    const context = contextOf(canvas);
    if (!context) return;
    view.stale = false;
    paint(context, canvas.clientWidth, canvas.clientHeight);
  };
  view.refresh = () => {
    view.stale = true;
    if (!view.seen || view.waiting) return;
    view.waiting = true;
    requestAnimationFrame(view.paint);
  };
  new IntersectionObserver((entries) => {
    view.seen = entries[entries.length - 1].isIntersecting;
    if (view.seen && view.stale) view.refresh();
  }, { rootMargin: "300px" }).observe(canvas);
  new ResizeObserver(view.refresh).observe(canvas);
  store.on(keys, view.refresh);
  views.push(view);
  return view;
}

// Pointer on a canvas: drag(x0, y0, x, y, done) while dragging, click(x, y), hover(x, y) -> row or null to tell of.
function addPointer(canvas, { drag, click, hover }) {
  let from = null;
  let moved = false;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    from = at(event);
    moved = false;
    // A finger scrolls the page; a mouse or pen brushes.
    if (drag && event.pointerType !== "touch") canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const [x, y] = at(event);
    if (from && drag && event.pointerType !== "touch") {
      moved = moved || Math.hypot(x - from[0], y - from[1]) > 4;
      if (moved) { hideTip(); drag(...from, x, y, false); }
      return;
    }
    const row = hover?.(x, y);
    canvas.style.cursor = row ? "pointer" : drag ? "crosshair" : "";
    if (row) showTip(tellingOf(row), event.clientX, event.clientY);
    else hideTip();
  });
  canvas.addEventListener("pointerup", (event) => {
    const [x, y] = at(event);
    if (from && moved) drag(...from, x, y, true);
    else if (from) click?.(x, y);
    from = null;
  });
  canvas.addEventListener("pointercancel", () => { from = null; });
  canvas.addEventListener("pointerleave", hideTip);
}

// Keys on a canvas: arrows walk along the finalists in the order of a dimension, Escape clears what is selected.
function addKeys(canvas, dimension, more = {}) {
  const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1, Home: -Infinity, End: Infinity };
  canvas.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    if (more[event.key]) more[event.key](event);
    else if (event.key in steps) pick(neighbour(dimension(), steps[event.key]));
    else if (event.key === "Escape") store.set({ ranges: Object.freeze({}) });
    else return;
    event.preventDefault();
  });
}

// The row whose mark is nearest to a place, within so many pixels; spot: row -> [x, y].
function nearestRow(rows, spot, x, y, within = 14) {
  let best = null;
  let least = within;
  for (const row of rows) {
    const [u, v] = spot(row);
    const apart = Math.hypot(u - x, v - y);
    // Among equals the finalist, drawn on top.
    if (apart <= least) { best = row; least = apart; }
  }
  return best;
}
