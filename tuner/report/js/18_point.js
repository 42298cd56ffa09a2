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
  store.on(["picked"], showPoint);
  showPoint();
}

function showPoint() {
  const row = byName.get(store.get().picked);
  byId("choose-point").value = row.name;
  byId("point-name").textContent = row.layer === "tuned" ? `${row.name}, ${data.called}` : row.name;
  byId("point-state").textContent = stateText(row);
  byId("point-metrics").replaceChildren(metricsTable(row));
  byId("point-gains").replaceChildren(gainsTable(row));
}

function stateText({ layer, point }) {
  const lost = point.lost ? ` It lost ${point.lost} of ${data.held_out} held-out flights.` : "";
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
  const at = (number) => 8 + 144 * placeIn(entry, number);
  const [x, y] = [at(value), 14];
  const drawing = draw("svg", { class: "drawing", viewBox: "0 0 160 28", width: 160, height: 28, "aria-hidden": "true" },
    draw("line", { x1: 8, y1: y, x2: 152, y2: y, class: "track" }),
    ...[8, 152].map((end) => draw("line", { x1: end, y1: 9, x2: end, y2: 19, class: "track" })),
    draw("rect", { x: at(entry.default) - 4, y: 10, width: 8, height: 8, class: "mark-default" }),
    draw("path", { d: `M${x} ${y - 6}l6 6l-6 6l-6 -6z`, class: "mark-tuned" }));
  const share = placeIn(entry, value);
  const remark = share <= 0.02 ? "at the low end" : share >= 0.98 ? "at the high end" : "";
  const ends = [entry.low, entry.log ? "log" : "linear", entry.high];
  return make("span", { class: "place" }, drawing,
    make("span", { class: "ends" }, ends.map((end) => make("span", {}, isNumber(end) ? significant(end) : end))),
    make("small", {}, remark));
}
