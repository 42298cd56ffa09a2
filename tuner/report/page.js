"use strict";
// Draws the figures of the report. Their traces and layouts are complete but for two kinds of names: "@colour" is resolved
// against the style sheet, so that a change of the colour scheme only needs another draw, and "#array" against the shared data.
(() => {
  const { charts, shared } = JSON.parse(document.getElementById("data").textContent);
  const byId = (id) => document.getElementById(id);
  const finger = window.matchMedia("(pointer: coarse)").matches;
  const config = {
    responsive: true,
    displaylogo: false,
    displayModeBar: false,
    doubleClick: "reset+autosize",
  };

  function colour(name) {
    const [variable, opacity] = name.slice(1).split("/");
    const hex = getComputedStyle(document.documentElement).getPropertyValue(`--${variable}`).trim();
    if (!opacity) return hex;
    const [red, green, blue] = [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
    return `rgba(${red},${green},${blue},${opacity})`;
  }

  function zip(names) {
    const columns = names.map((name) => shared[name.slice(1)]);
    return columns[0].map((_, i) => columns.map((column) => column[i]));
  }

  function resolved(value) {
    if (typeof value === "string") {
      if (value.startsWith("@")) return colour(value);
      return value.startsWith("#") ? shared[value.slice(1)] ?? value : value;
    }
    if (Array.isArray(value)) return typeof value[0] === "object" ? value.map(resolved) : value.slice();
    if (value === null || typeof value !== "object") return value;
    if (value.zip) return zip(value.zip);
    return Object.fromEntries(Object.entries(value).map(([key, entry]) => [key, resolved(entry)]));
  }

  function choices() {
    const off = [...document.querySelectorAll("[data-layer]")].filter((box) => !box.checked).map((box) => box.dataset.layer);
    const point = byId("choose-point");
    const points = point ? [point.value] : [];
    if (byId("behind")?.checked) points.push("default");
    const scenario = byId("choose-scenario")?.value;
    return { off, points, scenario };
  }

  function visible(meta, chosen) {
    if (!meta) return true;
    if (chosen.off.includes(meta.layer) || chosen.off.includes(meta.also)) return false;
    if (meta.point && !chosen.points.includes(meta.point)) return false;
    return !(meta.scenario && chosen.scenario && meta.scenario !== chosen.scenario);
  }

  function draw(name) {
    const { traces, layout } = charts[name];
    const chosen = choices();
    const shown = traces.filter((trace) => visible(trace.meta, chosen)).map(resolved);
    const look = resolved(layout);
    look.font.family = getComputedStyle(document.body).fontFamily;
    // One finger scrolls the page; figures are zoomed with a mouse.
    look.dragmode = look.scene ? "turntable" : finger ? false : "zoom";
    look.uirevision = "kept";
    // Drawn while it is visible, because a hidden element has no size.
    const figure = byId(name).closest("figure");
    figure.hidden = false;
    return Plotly.react(name, shown, look, config).then(() => { figure.hidden = Boolean(layout.meta?.hides) && !shown.length; });
  }

  const drawAll = () => Object.keys(charts).forEach(draw);
  const drawSome = (prefix) => Object.keys(charts).filter((name) => name.startsWith(prefix)).forEach(draw);

  // Zooming one response in time zooms all of them.
  function linkTimes() {
    const names = Object.keys(charts).filter((name) => name.startsWith("response-"));
    let busy = false;
    for (const name of names) {
      byId(name).on("plotly_relayout", (change) => {
        const keys = ["xaxis.range[0]", "xaxis.range[1]", "xaxis.autorange"].filter((key) => key in change);
        if (busy || !keys.length) return;
        busy = true;
        const same = Object.fromEntries(keys.map((key) => [key, change[key]]));
        Promise.all(names.filter((other) => other !== name).map((other) => Plotly.relayout(other, same)))
          .finally(() => { busy = false; });
      });
    }
  }

  async function copy(button) {
    const source = byId(button.dataset.copy);
    try {
      await navigator.clipboard.writeText(source.textContent);
    } catch {
      // A page opened from disk may not write to the clipboard: select the text, then copying is one key away.
      getSelection().selectAllChildren(source);
      document.execCommand("copy");
    }
    button.textContent = "Copied";
    setTimeout(() => { button.textContent = "Copy"; }, 2000);
  }

  function print(on) {
    document.documentElement.toggleAttribute("data-print", on);
    drawAll();
    if (!on) return;
    // Sizes given at once: Plotly.Plots.resize waits a moment, and paper does not.
    for (const name of Object.keys(charts).filter((name) => !byId(name).closest("figure").hidden)) {
      const { clientWidth: width, clientHeight: height } = byId(name);
      Plotly.relayout(name, { width, height });
    }
  }

  byId("layers")?.addEventListener("change", () => drawSome("front-"));
  byId("contenders")?.addEventListener("change", drawAll);
  byId("choices")?.addEventListener("change", () => drawSome("response-"));
  document.querySelectorAll("[data-copy]").forEach((button) => button.addEventListener("click", () => copy(button)));
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
  window.addEventListener("beforeprint", () => print(true));
  window.addEventListener("afterprint", () => print(false));
  drawAll();
  linkTimes();
})();
