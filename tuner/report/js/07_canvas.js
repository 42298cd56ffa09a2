// Canvases and the marks drawn on them. Layers differ in shape first, and in colour.

const COLOURS = {
  default: "default", tuned: "tuned", front: "front", finalist: "front", start: "other", searched: "faint", infeasible: "faint",
};
const SIZES = { default: 5, tuned: 6.5, front: 4, finalist: 4, start: 5.5, searched: 1.8, infeasible: 2.6 };
const ORDER = ["infeasible", "searched", "finalist", "front", "start", "default", "tuned"];
let palette = {};

const colour = (name) => {
  palette[name] ??= getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  return palette[name];
};
const forgetColours = () => { palette = {}; };
const typeface = () => getComputedStyle(document.body).fontFamily;

function faded(name, opacity) {
  const hex = colour(name);
  return `rgba(${[1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16)).join(",")},${opacity})`;
}

// A context cleared and scaled so that one unit is one CSS pixel; null while the canvas has no size.
function contextOf(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (!width || !height) return null;
  const ratio = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = `12px ${typeface()}`;
  return context;
}

const SHAPES = {
  default: (c, x, y, r) => { c.rect(x - r, y - r, 2 * r, 2 * r); },
  tuned: (c, x, y, r) => { c.moveTo(x, y - r); c.lineTo(x + r, y); c.lineTo(x, y + r); c.lineTo(x - r, y); c.closePath(); },
  start: (c, x, y, r) => { c.moveTo(x, y - r); c.lineTo(x + r, y + r); c.lineTo(x - r, y + r); c.closePath(); },
  infeasible: (c, x, y, r) => { c.moveTo(x - r, y - r); c.lineTo(x + r, y + r); c.moveTo(x + r, y - r); c.lineTo(x - r, y + r); },
};
const circle = (c, x, y, r) => { c.moveTo(x + r, y); c.arc(x, y, r, 0, 2 * Math.PI); };
const HOLLOW = new Set(["default", "finalist", "start", "infeasible"]);

function mark(context, layer, x, y, opacity = 1, scale = 1) {
  context.globalAlpha = opacity;
  context.beginPath();
  (SHAPES[layer] ?? circle)(context, x, y, SIZES[layer] * scale);
  if (HOLLOW.has(layer)) {
    if (layer === "default" || layer === "start") { context.fillStyle = colour("surface"); context.fill(); }
    context.strokeStyle = colour(COLOURS[layer]);
    context.lineWidth = layer === "infeasible" ? 1 : 1.8;
    context.stroke();
  } else {
    context.fillStyle = colour(COLOURS[layer]);
    context.fill();
  }
  context.globalAlpha = 1;
}

// A cross over the mark of a point that lost flights when held out.
function crossOut(context, x, y, opacity = 1, scale = 1) {
  const r = 7 * scale;
  context.globalAlpha = opacity;
  stroke(context, x - r, y - r, x + r, y + r, colour("bad"), 1.6);
  stroke(context, x + r, y - r, x - r, y + r, colour("bad"), 1.6);
  context.globalAlpha = 1;
}

// An arrow head at the edge of a view, towards a point that lies beyond its axes.
function arrowHead(context, layer, x, y, [dx, dy], opacity = 1, scale = 1) {
  const size = Math.hypot(dx, dy) || 1;
  const [a, b] = [(8 * scale * dx) / size, (8 * scale * dy) / size];
  context.globalAlpha = opacity;
  context.beginPath();
  context.moveTo(x + a, y + b);
  context.lineTo(x - a - 0.6 * b, y - b + 0.6 * a);
  context.lineTo(x - a + 0.6 * b, y - b - 0.6 * a);
  context.closePath();
  context.fillStyle = colour(COLOURS[layer]);
  context.fill();
  context.globalAlpha = 1;
}

// The ring around the picked point.
function ring(context, x, y, radius = 10) {
  context.beginPath();
  circle(context, x, y, radius);
  context.strokeStyle = colour("ink");
  context.lineWidth = 2;
  context.stroke();
}

function stroke(context, x1, y1, x2, y2, style, width = 1) {
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.strokeStyle = style;
  context.lineWidth = width;
  context.stroke();
}

let visible = { layers: null, rows: [] };

// Visible rows from back to front: those of the search only where they are asked for.
function visibleRows(layers) {
  if (visible.layers === layers) return visible.rows;
  const searched = layers.searched || layers.infeasible || (layers.start && data.candidates.start);
  const all = [...(searched ? candidates() : []), ...finalists];
  visible = { layers, rows: ORDER.filter((layer) => layers[layer]).flatMap((layer) => all.filter((row) => row.layer === layer)) };
  return visible.rows;
}
