// A slider, a field and marks for each gain, on the study's own scale.

const SLIDER_STEPS = 1000;

const shareOf = (gain, value) => {
  const held = Math.min(Math.max(value, gain.low), gain.high);
  return gain.scale === "log" ? Math.log(held / gain.low) / Math.log(gain.high / gain.low) : (held - gain.low) / (gain.high - gain.low);
};

// The value at a share of the range, to four digits, and a multiple of the gain's step where it has one.
function valueFor(gain, share) {
  const exact = gain.scale === "log" ? gain.low * (gain.high / gain.low) ** share : gain.low + share * (gain.high - gain.low);
  const rounded = gain.step ? gain.step * Math.round(exact / gain.step) : Number(exact.toPrecision(4));
  return Math.min(Math.max(rounded, gain.low), gain.high);
}

const idOf = (gain, part) => `${part}-${studio.study.gains.indexOf(gain)}`;

function setValue(name, value) {
  studio.values = { ...studio.values, [name]: value };
  showGain(gainOf(name));
  request();
}

function showGain(gain) {
  const value = studio.values[gain.name];
  const slider = byId(idOf(gain, "slider"));
  slider.value = String(Math.round(SLIDER_STEPS * shareOf(gain, value)));
  slider.setAttribute("aria-valuetext", withUnit(significant(value), gain.unit));
  const field = byId(idOf(gain, "field"));
  field.removeAttribute("aria-invalid");
  field.value = String(Number(value.toPrecision(6)));
}

function typed(gain, field) {
  const value = Number(field.value);
  const right = field.value !== "" && Number.isFinite(value) && value >= gain.low && value <= gain.high;
  if (!right) {
    field.setAttribute("aria-invalid", "true");
    complain(`${gain.name}: given ${field.value || "nothing"}; allowed: ${significant(gain.low)} to ${withUnit(significant(gain.high), gain.unit)}.`);
    return;
  }
  complain("");
  setValue(gain.name, value);
  remember();
}

// A mark below the slider, which takes its value over.
function markOf(gain, key, name, value, sign) {
  const button = make("button", { type: "button", class: key, title: `${name}: ${significant(value)}`,
    "aria-label": `${gain.name}: take the ${name} value ${withUnit(significant(value), gain.unit)}`,
    onclick: () => { setValue(gain.name, value); remember(); } }, sign);
  button.style.left = `${100 * shareOf(gain, value)}%`;
  return button;
}

function gainRow(gain) {
  const slider = make("input", { type: "range", id: idOf(gain, "slider"), min: "0", max: String(SLIDER_STEPS), step: "1",
    oninput: (event) => { complain(""); setValue(gain.name, valueFor(gain, Number(event.target.value) / SLIDER_STEPS)); }, onchange: remember });
  const field = make("input", { type: "number", id: idOf(gain, "field"), step: "any", "aria-label": `${gain.name}, value`,
    onchange: (event) => typed(gain, event.target) });
  const marks = [markOf(gain, "default", "default", gain.default, "■")];
  if (gain.tuned !== null) marks.push(markOf(gain, "tuned", studio.study.tunedName, gain.tuned, "◆"));
  return make("div", { class: "gain" },
    make("div", { class: "gain-head" },
      make("label", { for: idOf(gain, "slider") }, term(gain.name, `${gain.symbol} ${gain.meaning}`.trim()), gain.unit ? [" [", ...unitOf(gain.unit), "]"] : []), field),
    slider, make("div", { class: "marks" }, marks),
    make("div", { class: "gain-ends" }, make("span", {}, significant(gain.low)), make("span", {}, significant(gain.high))));
}

// Take a whole setting over: default, tuned, a pin or a point.
function takeOver(values) {
  studio.values = { ...studio.values, ...values };
  studio.study.gains.forEach(showGain);
  remember();
  request();
}

const allOf = (key) => Object.fromEntries(studio.study.gains.map((gain) => [gain.name, gain[key]]));

function startGains() {
  byId("sliders").replaceChildren(...studio.study.gains.map(gainRow));
  const buttons = [
    make("button", { type: "button", id: "undo", onclick: () => travel(-1) }, "Undo"),
    make("button", { type: "button", id: "redo", onclick: () => travel(1) }, "Redo"),
    make("button", { type: "button", onclick: () => takeOver(allOf("default")) }, "Default"),
  ];
  if (studio.study.tunedName) {
    buttons.push(make("button", { type: "button", onclick: () => takeOver(allOf("tuned")) }, capital(studio.study.tunedName)));
  }
  byId("history").replaceChildren(...buttons);
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || event.target.matches("input[type=number], .text-field")) return;
    event.preventDefault();
    travel(event.shiftKey ? 1 : -1);
  });
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

function showHistory() {
  byId("undo").disabled = history.at <= 0;
  byId("redo").disabled = history.at >= history.states.length - 1;
}
