// Pins: up to four named settings, drawn and compared next to the one at hand.

function pin() {
  if (studio.pins.length >= MAX_PINS) { complain(`At most ${MAX_PINS} pins; remove one first.`); return; }
  studio.pins = [...studio.pins, { name: `pin ${studio.pins.length + 1}`, values: studio.values }];
  changePins();
}

function changePins() {
  showPins();
  showLayers();
  remember();
  request();
}

function pinRow(entry, i) {
  const name = make("input", { class: "text-field", type: "text", maxlength: String(MAX_NAME), "aria-label": `Name of pin ${i + 1}`, value: entry.name,
    onchange: (event) => { studio.pins = studio.pins.map((one, k) => (k === i ? { ...one, name: event.target.value || `pin ${i + 1}` } : one)); changePins(); } });
  return make("div", { class: "pin" }, make("span", { class: `swatch pin${i + 1}`, "aria-hidden": "true" }), name,
    make("button", { type: "button", "aria-label": `Take the gains of ${entry.name}`, onclick: () => takeOver(entry.values) }, "Take"),
    make("button", { type: "button", "aria-label": `Remove ${entry.name}`, onclick: () => { studio.pins = studio.pins.filter((_, k) => k !== i); changePins(); } }, "Remove"));
}

function showPins() {
  byId("pins").replaceChildren(...studio.pins.map(pinRow),
    make("div", { class: "actions" }, make("button", { type: "button", id: "pin", onclick: pin }, "Pin this setting")));
}
