// The picked point: its numbers against the default's, its gains and their place in the ranges.

function startPoint() {
  const choice = byId("choose-point");
  if (!choice) return;
  choice.append(...finalists.map((row) => make("option", { value: row.name },
    row.layer === "tuned" ? `${row.name}, ${data.called}` : row.name)));
  choice.addEventListener("change", () => pick(choice.value));
  byId("previous").addEventListener("click", () => pick(neighbour(store.get().x, -1)));
  byId("next").addEventListener("click", () => pick(neighbour(store.get().x, 1)));
  byId("save-point").addEventListener("click", () => saveGains(store.get().picked));
  byId("copy-point").addEventListener("click", (event) => copyText(gainsText(store.get().picked), event.currentTarget));
  for (const show of [showPoint, showMargins]) {
    store.on(["picked"], show);
    show();
  }
  store.on(["picked", "scenario"], tellResponses);
  tellResponses();
}

let recommendedGains = null;

function showPoint() {
  const row = byName.get(store.get().picked);
  byId("choose-point").value = row.name;
  byId("point-name").textContent = row.layer === "tuned" ? `${row.name}, ${data.called}` : row.name;
  byId("point-state").textContent = stateText(row);
  // The table at the top tells of the recommended point what stands here of any other.
  byId("point-numbers").open = row.layer !== "tuned";
  byId("point-metrics").replaceChildren(metricsTable(row));
  recommendedGains ??= byId("point-gains").firstElementChild;
  byId("point-gains").replaceChildren(row.layer === "tuned" ? recommendedGains : gainsTable(row));
}

function stateText({ layer, point }) {
  const lost = point.lost ? ` It lost ${point.lost} of ${point.flights ?? data.held_out} held-out flights.` : "";
  if (layer === "default") return `The default gains, which everything is measured by.${lost}`;
  const said = [`It is ${point.front ? "" : "not "}on the held-out front`];
  if (isNumber(point.probability)) said.push(`and non-dominated on ${perCent(point.probability)} of the resamples`);
  return `${said.join(" ")}. It ${point.feasible ? "keeps every limit" : "breaks a limit"} there.${lost}`;
}

const SIGNS = { better: "✓", kept: "✓", worse: "✗", broken: "✗", "no clear difference": "≈" };
const verdictMark = (word) => make("span", { class: `verdict ${word.replaceAll(" ", "-")}` }, `${SIGNS[word] ?? ""} ${word}`.trim());

function numberCell({ value, low, high }, signed = false) {
  const [text, interval] = estimate(value, low, high, signed);
  return make("span", { class: "number" }, text, interval === MISSING ? null : make("small", { class: "interval" }, interval));
}

// Numbers of a requirement as shown: 20 log10 of factors where it is told in dB, else by its factor.
const shownNumber = (entry, value) => (entry.decibel ? 20 * Math.log10(value) : value * entry.factor);

// Default, point and difference of a quantity as shown; in dB the difference is that of the levels.
function shownEstimates(entry, parts) {
  if (!entry.decibel) return parts.map((part) => Object.fromEntries(Object.entries(part).map(([key, value]) => [key, isNumber(value) ? value * entry.factor : null])));
  const [before, mine] = parts.map(({ value }) => (isNumber(value) ? shownNumber(entry, value) : null));
  const apart = isNumber(before) && isNumber(mine) ? mine - before : null;
  return [before, mine, apart].map((value) => ({ value, low: null, high: null }));
}

// Rows of every quantity: its limit, the default, this point, the difference and the verdict.
function metricsTable({ point }) {
  const kinds = [["objective", objectives], ["constraint", data.constraints], ["requirement", data.requirements]];
  const rows = kinds.flatMap(([kind, entries]) => entries.map((entry) => {
    const [plain, mine, apart] = judged({ kind, label: entry.label }, point);
    const limit = entry.limit == null ? MISSING : `at ${entry.sense ?? "most"} ${significant(shownNumber(entry, entry.limit))}`;
    const cells = shownEstimates(entry, [plain, mine, apart]).map((part, i) => numberCell(part, i === 2));
    return [
      term(entry.label, entry.definition), entry.unit || MISSING, limit, ...cells,
      verdictMark(verdictOf({ kind, limit: entry.limit, sense: entry.sense }, mine.value, apart)),
    ];
  }));
  return tableOf(["Quantity", "Unit", "Limit", "Default", point.name, "Difference", "Verdict"], rows, { class: "stacked" });
}

function gainsTable({ point }) {
  const rows = variables.map((entry, i) => [
    term(entry.name, entry.definition ?? entry.meaning), make("span", {}, entry.written === "1" ? MISSING : unitOf(entry.written)),
    make("span", { class: "number" }, significant(entry.default)),
    make("strong", { class: "number" }, significant(point.gains[i])),
    placeCell(entry, point.gains[i]),
  ]);
  return tableOf(["Gain", "Unit", "Default", point.name, "Place in the search range"], rows, { class: "stacked gains" });
}

// The range as a line with the default (square) and the point (diamond) on it.
function placeCell(entry, value) {
  const at = (number) => 12 + 136 * held(placeIn(entry, number), { low: 0, high: 1 });
  const [x, y] = [at(value), 9];
  const drawing = draw("svg", { class: "strip", viewBox: "0 0 160 18", width: 160, height: 18, "aria-hidden": "true" },
    draw("line", { x1: 12, y1: y, x2: 148, y2: y, class: "track" }),
    ...[12, 148].map((end) => draw("line", { x1: end, y1: y - 5, x2: end, y2: y + 5, class: "track" })),
    draw("rect", { x: at(entry.default) - 3.5, y: y - 3.5, width: 7, height: 7, class: "mark hollow default" }),
    draw("path", { d: `M${x} ${y - 5}l5 5l-5 5l-5 -5z`, class: "mark tuned" }));
  const share = placeIn(entry, value);
  const end = share <= 0.02 ? "low" : share >= 0.98 ? "high" : "";
  const why = entry.fixed_ends.includes(end) ? "which cannot be moved" : "a wider range may do better";
  const remark = end && `at the ${end} end: ${why}`;
  const ends = [entry.low, entry.log ? "log" : "linear", entry.high];
  return make("span", { class: "place" }, drawing,
    make("span", { class: "ends" }, ends.map((end) => make("span", {}, isNumber(end) ? significant(end) : end))),
    make("small", {}, remark));
}

// Whose responses are shown, and in which flight it did worst.
function tellResponses() {
  const holder = byId("responses-of");
  if (!holder) return;
  const { picked, scenario } = store.get();
  const flights = data.responses.flights[scenario];
  const worst = isNumber(flights[picked]) ? `; its worst flight is number ${flights[picked]}` : "";
  holder.textContent = picked in flights ? `${picked} in ${scenario}${worst}`
    : `No responses of ${picked} are kept; ${Object.keys(flights).length} other points have them.`;
}

// The margins of every loop of the picked point.
function showMargins() {
  const holder = byId("margins");
  if (!holder) return;
  const { picked } = store.get();
  const { quantities, points } = data.margins;
  const rows = (points[picked] ?? []).map((loop) => [
    loop.channel, loop.stable ? "yes" : "no",
    ...quantities.map(({ name, factor, decibel }) => {
      const value = loop.values[name];
      if (!isNumber(value)) return loop.stable ? "∞" : MISSING;
      return make("span", { class: "number" }, significant(decibel ? 20 * Math.log10(value) : value * factor, 3));
    }),
    loop.case || MISSING,
  ]);
  const head = ["Loop", "Stable", ...quantities.map(({ label, unit, meaning }) => term(unit ? `${label} [${unit}]` : label, meaning)), "Amplitude shown"];
  holder.replaceChildren(rows.length ? tableOf(head, rows, { class: "margins stacked" }) : make("p", { class: "note" }, `No loops of ${picked} are kept.`));
}
