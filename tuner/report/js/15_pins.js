// Pins: up to four finalists whose responses and loops are laid over those of the picked point.

function togglePin(name) {
  const { pins } = store.get();
  const has = pins.includes(name);
  if (name === "default" || (!has && pins.length >= data.pins.length)) {
    announce(name === "default" ? "The default has a switch of its own." : `At most ${data.pins.length} pins; remove one first.`);
    return;
  }
  store.set({ pins: Object.freeze(has ? pins.filter((one) => one !== name) : [...pins, name]) });
  window.history.replaceState(null, "", address());
  announce(`${has ? "Removed the pin of" : "Pinned"} ${wordsOf(name)}; ${store.get().pins.length} of ${data.pins.length} pins`);
}

const canPin = (name) => name !== "default" && (store.get().pins.includes(name) || store.get().pins.length < data.pins.length);

// A button that pins a point, or removes its pin.
const pinButton = (name) => make("button", {
  type: "button", class: "pinner", "data-pin": name, "aria-pressed": String(store.get().pins.includes(name)), disabled: !canPin(name),
  "aria-label": `Pin ${wordsOf(name)}`, onclick: () => togglePin(name),
}, "Pin");

// The line of a pin, as charts draw it.
const pinSample = ({ line }) => draw("svg", { class: "icon", viewBox: "0 0 40 16", width: 40, height: 16, "aria-hidden": "true" },
  draw("path", { d: "M1 8h38", class: `stroke ${line.color.slice(1)}`, "stroke-dasharray": line.dash === "solid" ? null : line.dash.replaceAll("px", "") }));

function showPinned() {
  const { picked, pins } = store.get();
  byId("pin").setAttribute("aria-pressed", String(pins.includes(picked)));
  byId("pin").disabled = !canPin(picked);
  // Without responses and loops there is nothing to lay over each other but marks and values.
  byId("pins")?.replaceChildren(...pins.map((name, k) => make("span", { class: "key" }, pinSample(data.pins[k]),
    make("button", { type: "button", class: "chip", "data-point": name, onclick: () => pick(name) }, heading(name)),
    make("button", { type: "button", class: "chip", "aria-label": `Remove the pin of ${wordsOf(name)}`, onclick: () => togglePin(name) }, "×"))));
}

function startPins() {
  byId("pin").addEventListener("click", () => togglePin(store.get().picked));
  store.on(["picked", "pins"], showPinned);
  showPinned();
}
