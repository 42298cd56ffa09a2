// Sliders that move many gains together: a rule of `tuner design` for a plant, similarity in time for a quadrotor.

function ruleSlider({ key, label, low, high, at, unit }, moved) {
  const id = `design-${key}`;
  const scale = { low, high, scale: "log", step: unit ? 0 : 0.01 };
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
  return { key, value, row: make("div", { class: "gain" }, make("div", { class: "gain-head" }, make("label", { for: id }, label), shown), slider,
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
  const at = () => Object.fromEntries(sliders.map(({ key, value }) => [key, value()]));
  const state = { busy: false, again: false, made: null, values: null, from: null, at: null };
  const move = async () => {
    if (state.busy) { state.again = true; return; }
    // Values that were moved otherwise are those of the sliders as they were.
    if (studio.values !== state.made) Object.assign(state, { values: studio.values, from: state.at });
    Object.assign(state, { busy: true, again: false, at: at() });
    const { values, text, error } = await answered("/design", { values: state.values, from: state.from, at: state.at });
    state.busy = false;
    note.textContent = error ?? text;
    if (values) {
      studio.values = { ...studio.values, ...values };
      state.made = studio.values;
      studio.study.gains.forEach(showGain);
      request();
    }
    if (state.again) move(); else remember();
  };
  const sliders = design.sliders.map((slider) => ruleSlider(slider, move));
  state.at = at();
  byId("design").replaceChildren(make("h3", {}, `Speed and robustness (${design.method})`), ...sliders.map(({ row }) => row), note,
    ...(design.note ? [make("p", { class: "aid" }, design.note)] : []));
}
