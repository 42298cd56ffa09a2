// Two sliders that move all gains of a plant together, through a rule of `tuner design`.

function ruleSlider(id, label, low, high, at, unit, step, moved) {
  const scale = { low, high, scale: "log", step };
  const shown = make("output", { for: id, class: "number" });
  const slider = make("input", { type: "range", id, min: "0", max: String(SLIDER_STEPS), value: String(Math.round(SLIDER_STEPS * shareOf(scale, at))) });
  const value = () => valueFor(scale, Number(slider.value) / SLIDER_STEPS);
  const tell = () => {
    shown.textContent = withUnit(significant(value(), 3), unit);
    slider.setAttribute("aria-valuetext", shown.textContent);
  };
  slider.addEventListener("input", () => { tell(); moved(); });
  slider.addEventListener("change", remember);
  tell();
  return { value, row: make("div", { class: "gain" }, make("div", { class: "gain-head" }, make("label", { for: id }, label), shown), slider,
    make("div", { class: "gain-ends below" }, make("span", {}, significant(low)), make("span", {}, significant(high)))) };
}

function startDesign() {
  const { design } = studio.study;
  if (!design) {
    byId("design").replaceChildren(make("p", { class: "aid" },
      "No sliders for speed and robustness: no rule of `tuner design` has a closed-loop time for these laws. Move the gains."));
    return;
  }
  const note = make("p", { class: "aid", role: "status" });
  const state = { busy: false, again: false };
  const move = async () => {
    if (state.busy) { state.again = true; return; }
    Object.assign(state, { busy: true, again: false });
    const { values, text, error } = await answered("/design", { time: time.value(), robustness: robustness.value() });
    state.busy = false;
    note.textContent = error ?? text;
    if (values) {
      studio.values = { ...studio.values, ...values };
      studio.study.gains.forEach(showGain);
      request();
    }
    if (state.again) move(); else remember();
  };
  const time = ruleSlider("design-time", "Closed-loop time", design.low, design.high, Math.sqrt(design.low * design.high), "s", 0, move);
  const robustness = ruleSlider("design-robustness", "Robustness", ...design.robustness, 1, "", 0.01, move);
  byId("design").replaceChildren(make("h3", {}, `Speed and robustness (${design.method})`), time.row, robustness.row, note);
}
