// Tables of an answer: objectives and limits of the setting at hand next to others, and the margins of each loop.

const cellOf = ([value, interval]) => [make("span", { class: "number" }, value), interval ? make("small", { class: "interval" }, interval) : null];
const wordOf = ({ word, text }) => (text ? make("span", { class: `verdict ${word}` }, text) : null);

function nameOf(row) {
  return [term(row.name, row.tip), row.unit ? ` [${row.unit}]` : "", make("small", {}, [row.limit, row.state && `worst: ${row.state}`, row.evidence].filter(Boolean).join(", "))];
}

// A setting to compare with: its value, and below it the paired difference of the setting at hand.
const otherCell = (row, i) => make("td", { class: row.broken[i] ? "broken" : "" }, cellOf(row.others[i]),
  make("small", { class: "difference" }, `here: ${row.changes[i].join(" ")}`), wordOf(row.words[i]));

function judgedRow(row, count) {
  return make("tr", {}, make("th", { scope: "row" }, nameOf(row)), make("td", { class: row.verdict.word }, cellOf(row.here), wordOf(row.verdict)),
    Array.from({ length: count }, (_, i) => otherCell(row, i)));
}

function judgedTable(rows, others) {
  const head = ["Quantity", "Here", ...others.map(({ name }) => capital(name))];
  const groups = [["Objectives: smaller is better", "objective"], ["Limits", "constraint"], ["Limits computed from the model", "requirement"]];
  const bodies = groups.map(([title, kind]) => [title, rows.filter((row) => row.kind === kind)]).filter(([, mine]) => mine.length)
    .map(([title, mine]) => make("tbody", {}, make("tr", { class: "group" }, make("th", { scope: "rowgroup", colspan: String(head.length) }, title)),
      mine.map((row) => judgedRow(row, others.length))));
  return make("table", {}, make("caption", { class: "hidden" }, "Objectives and limits of the setting at hand"),
    make("thead", {}, make("tr", {}, head.map((name) => make("th", { scope: "col" }, name)))), bodies);
}

function loopTable({ channels, rows }) {
  const cells = rows.map(({ name, unit, cells: values }) => [`${name}${unit ? ` [${unit}]` : ""}`, ...values]);
  return tableOf(["margin", ...channels], cells);
}

function showNumbers(answer) {
  byId("table").replaceChildren(judgedTable(answer.rows, answer.others));
  byId("evidence").textContent = `${answer.flights} ${studio.study.noun} of each scenario, 95 % intervals, differences paired. ${answer.note}`.trim();
  if (answer.loops) {
    byId("loop-table").replaceChildren(loopTable(answer.loops));
    byId("loop-fold").hidden = false;
  }
}
