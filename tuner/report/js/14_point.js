// The picked point: its numbers against the default's, its gains and their place in the ranges.

function startPoint() {
  const choice = byId("choose-point");
  if (!choice) return;
  choice.append(...finalists.map((row) => make("option", { value: row.name }, wordsOf(row.name))));
  choice.addEventListener("change", () => pick(choice.value));
  byId("previous").addEventListener("click", () => pick(neighbour(store.get().x, -1)));
  byId("next").addEventListener("click", () => pick(neighbour(store.get().x, 1)));
  byId("save-point").addEventListener("click", () => saveGains(store.get().picked));
  byId("copy-point").addEventListener("click", (event) => copyText(gainsText(store.get().picked), event.currentTarget));
  for (const show of [showPoint, showMargins]) {
    store.on(["picked", "pins"], show);
    show();
  }
  store.on(["picked", "scenario"], tellResponses);
  tellResponses();
}

let recommendedGains = null;

function showPoint() {
  const row = byName.get(store.get().picked);
  byId("choose-point").value = row.name;
  byId("point-name").textContent = heading(row.name);
  byId("point-state").textContent = row.point.texts.state;
  byId("point-why").textContent = row.point.texts.why;
  // The table at the top tells of the recommended point what stands here of any other.
  byId("point-numbers").open = row.layer !== "tuned" || store.get().pins.length > 0;
  byId("point-metrics").replaceChildren(metricsTable(row));
  recommendedGains ??= byId("point-gains").firstElementChild;
  byId("point-gains").replaceChildren(row.layer === "tuned" ? recommendedGains : gainsTable(row));
}

// Rows of every quantity: its limit, the default, this point, the difference and the verdict, then the pinned points.
function metricsTable({ point }) {
  const others = store.get().pins.filter((name) => name !== point.name);
  const rows = data.quantities.map((entry, i) => {
    const { value, difference, verdict, style } = point.texts.quantities[i];
    const pinned = others.map((name) => numberCell(byName.get(name).point.texts.quantities[i].value));
    return [
      term(entry.label, entry.definition), entry.unit, entry.limit, ...[entry.default, value, difference].map(numberCell),
      make("span", { class: `verdict ${style}` }, verdict), ...pinned,
    ];
  });
  return tableOf(["Quantity", "Unit", "Limit", "Default", heading(point.name), "Difference", "Verdict", ...others.map(heading)], rows, { class: "stacked" });
}

function gainsTable({ point }) {
  const rows = variables.map((entry, i) => {
    const { value, place, remark } = point.texts.gains[i];
    return [
      term(entry.name, entry.meaning), make("span", {}, unitOf(entry.written)), make("span", { class: "number" }, entry.shown),
      make("strong", { class: "number" }, value), placeCell(entry, place, remark),
    ];
  });
  return tableOf(["Gain", "Unit", "Default", heading(point.name), "Place in the search range"], rows, { class: "stacked gains" });
}

// The range as a line with the default (square) and the point (diamond) on it.
function placeCell(entry, place, remark) {
  const at = (share) => 12 + 136 * share;
  const [x, y] = [at(place), 9];
  const drawing = draw("svg", { class: "strip", viewBox: "0 0 160 18", width: 160, height: 18, "aria-hidden": "true" },
    draw("line", { x1: 12, y1: y, x2: 148, y2: y, class: "track" }),
    ...[12, 148].map((end) => draw("line", { x1: end, y1: y - 5, x2: end, y2: y + 5, class: "track" })),
    draw("rect", { x: at(entry.place) - 3.5, y: y - 3.5, width: 7, height: 7, class: "mark hollow default" }),
    draw("path", { d: `M${x} ${y - 5}l5 5l-5 5l-5 -5z`, class: "mark tuned" }));
  return make("span", { class: "place" }, drawing,
    make("span", { class: "ends" }, entry.ends.map((end) => make("span", {}, end))), make("small", {}, remark));
}

// Whose responses are shown, and in which flight it did worst.
function tellResponses() {
  const holder = byId("responses-of");
  if (!holder) return;
  const { picked, scenario } = store.get();
  const flights = data.responses.flights[scenario];
  const worst = isNumber(flights[picked]) ? `; worst case: number ${flights[picked]}` : "";
  holder.textContent = picked in flights ? `${heading(picked)} in ${scenario}${worst}`
    : `No responses of ${wordsOf(picked)} are stored; ${Object.keys(flights).length} other points have them.`;
}

// The margins of every loop of the picked point.
function showMargins() {
  const holder = byId("margins");
  if (!holder) return;
  const { picked } = store.get();
  const rows = byName.get(picked).point.texts.loops.map(([channel, stable, ...texts]) =>
    [channel, stable, ...texts.map((text) => make("span", { class: "number" }, text))]);
  const head = ["Loop", "Stable", ...data.margins.map(([text, meaning]) => term(text, meaning)), "Amplitude shown"];
  holder.replaceChildren(rows.length ? tableOf(head, rows, { class: "margins stacked" }) : make("p", { class: "note" }, `No loops of ${wordsOf(picked)} are stored.`));
}
