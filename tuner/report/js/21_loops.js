// Bode and Nyquist curves of the picked point and the default, with the margins of every loop.

const loops = data.loops;
const curves = new Map();

function startLoops() {
  if (!loops) return;
  const choice = byId("choose-channel");
  choice.addEventListener("change", () => store.set({ channel: Number(choice.value) }));
  const keys = ["picked", "channel", "behind"];
  addPlot("loop-gain", keys, () => bodeFigure("gain", "gain [dB]", [-60, 60]));
  addPlot("loop-phase", keys, () => bodeFigure("phase", "phase [°]"));
  addPlot("loop-nyquist", keys, nyquistFigure);
  linkAcross("loop-gain");
  store.on(["picked"], showMargins);
  showMargins();
}

// Loop transfer function of a point in a channel: real, imag, gain [dB] and phase [deg], unwrapped; null where not known.
function curveOf(name, channel) {
  const key = JSON.stringify([name, channel]);
  if (!curves.has(key)) curves.set(key, decodedCurve(name, channel));
  return curves.get(key);
}

function decodedCurve(name, channel) {
  const entry = loops.points[name]?.find((loop) => loop.channel === channel);
  const packed = entry && (entry.curve ?? loops.points[name].find((loop) => loop.channel === entry.as)?.curve);
  if (!packed) return null;
  const both = singles(packed);
  const real = both.subarray(0, both.length / 2);
  const imag = both.subarray(both.length / 2);
  const gain = Array.from(real, (re, i) => 20 * Math.log10(Math.max(Math.hypot(re, imag[i]), 1e-12)));
  return { real: Array.from(real), imag: Array.from(imag), gain, phase: unwrappedPhase(real, imag, gain) };
}

// Phase without jumps, within (-360, 0] where the gain falls through 0 dB for the last time.
function unwrappedPhase(real, imag, gain) {
  const phase = Array.from(real, (re, i) => (180 / Math.PI) * Math.atan2(imag[i], re));
  for (let i = 1; i < phase.length; i += 1) phase[i] -= 360 * Math.round((phase[i] - phase[i - 1]) / 360);
  const last = Math.max(gain.findLastIndex((value) => value > 0), 0);
  const turns = Math.ceil(phase[last] / 360);
  return phase.map((value) => value - 360 * turns);
}

function shownCurves() {
  const { picked, channel, behind } = store.get();
  const names = [...new Set([...(behind ? ["default"] : []), picked])];
  return names.map((name) => [name, curveOf(name, loops.channels[channel])]).filter(([, curve]) => curve);
}

const curveLine = (name) => ({ color: colour(roleOf(name)), width: 1.8, dash: roleOf(name) === "default" ? "6px,3px" : "solid" });

function bodeFigure(part, title, range) {
  const shown = shownCurves();
  if (!shown.length) return null;
  loops.radians ??= Array.from(singles(loops.frequency));
  const traces = shown.map(([name, curve]) => ({
    type: "scatter", mode: "lines", x: loops.radians, y: curve[part], line: curveLine(name),
    hovertemplate: `${escaped(name)}: %{y:.1f} at %{x:.3~g} rad/s<extra></extra>`,
  }));
  const rule = { type: "line", xref: "paper", x0: 0, x1: 1, y0: part === "gain" ? 0 : -180, y1: part === "gain" ? 0 : -180,
    line: { color: colour("muted"), width: 1, dash: "dot" } };
  const y = axisLook(title, range ? { range } : { dtick: 90 });
  return { traces, layout: layoutOf(axisLook("frequency [rad/s]", { type: "log", dtick: 1 }), y, { shapes: [rule] }) };
}

function nyquistFigure() {
  const shown = shownCurves();
  if (!shown.length) return null;
  const traces = shown.map(([name, curve]) => ({
    type: "scatter", mode: "lines", x: curve.real, y: curve.imag, line: curveLine(name),
    customdata: loops.radians ??= Array.from(singles(loops.frequency)),
    hovertemplate: `${escaped(name)}: %{x:.2f} %{y:+.2f}i at %{customdata:.3~g} rad/s<extra></extra>`,
  }));
  traces.push({ type: "scatter", mode: "markers", x: [-1], y: [0], marker: { symbol: "cross-thin-open", size: 11, color: colour("ink") },
    hovertemplate: "−1<extra></extra>" });
  // Within this circle around -1 the sensitivity would exceed 2.
  const ms = { type: "circle", x0: -1.5, x1: -0.5, y0: -0.5, y1: 0.5, line: { color: colour("muted"), width: 1, dash: "dot" } };
  const x = axisLook("real part", { range: [-3.2, 1.2] });
  const y = axisLook("imaginary part", { range: [-2.2, 2.2], scaleanchor: "x" });
  return { traces, layout: layoutOf(x, y, { shapes: [ms] }) };
}

function showMargins() {
  const { picked } = store.get();
  const known = loops.points[picked] ?? [];
  const rows = known.map((loop) => [
    loop.channel, loop.stable ? "yes" : "no",
    ...loops.quantities.map(({ name, factor, decibel }) => {
      const value = loop.values[name];
      if (!isNumber(value)) return loop.stable ? "∞" : MISSING;
      return make("span", { class: "number" }, significant(decibel ? 20 * Math.log10(value) : value * factor, 3));
    }),
    loop.case || MISSING,
  ]);
  const head = ["Loop", "Stable", ...loops.quantities.map(({ label, unit, meaning }) => term(unit ? `${label} [${unit}]` : label, meaning)),
    "Amplitude shown"];
  byId("margins").replaceChildren(rows.length ? tableOf(head, rows)
    : make("p", { class: "note" }, `No loops of ${picked} are kept.`));
}
