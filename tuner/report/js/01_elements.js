// Elements of the page. Whatever comes from the data becomes text, never markup.

const byId = (id) => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value != null) element.setAttribute(name, value);
  }
  element.append(...children.flat().filter((child) => child != null));
  return element;
}

// An element with attributes ("onclick" and the like: a listener) and children: elements or text.
const make = (tag, attributes = {}, ...children) => filled(document.createElement(tag), attributes, children);
const draw = (tag, attributes = {}, ...children) => filled(document.createElementNS(SVG, tag), attributes, children);

// A word whose definition is shown under the pointer and on focus.
const term = (text, definition) =>
  make("span", definition ? { class: "term", tabindex: "0", "data-tip": definition } : {}, text);

// Plotly takes a few tags in its texts.
const escaped = (text) =>
  String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");

// A unit with its exponents raised, as elements: "rad^(1/2) s^-1".
function unitOf(text) {
  return String(text).split(/(\^(?:\([^)]*\)|-?\d+))/).map((part) =>
    part.startsWith("^") ? make("sup", {}, part.slice(1).replace(/[()]/g, "").replace("-", "−")) : part);
}

// A table; its first column heads its rows, and cells carry the name of their column for narrow screens.
function tableOf(head, rows, attributes = {}) {
  const names = head.map((cell) => (typeof cell === "string" ? cell : cell.textContent));
  const row = (cells) => make("tr", {}, cells.map((cell, i) => (i
    ? make("td", { "data-label": names[i] }, make("div", {}, cell))
    : make("th", { scope: "row" }, cell))));
  return make("table", attributes,
    make("thead", {}, make("tr", {}, head.map((cell) => make("th", { scope: "col" }, cell)))),
    make("tbody", {}, rows.map(row)));
}

// Say something to screen readers without moving the focus.
function announce(text) {
  const region = byId("announcer");
  if (region) region.textContent = text;
}
