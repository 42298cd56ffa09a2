// The finalists as a table: those selected, in the order that the reader chooses.

function startFinalists() {
  const holder = byId("finalists");
  if (!holder) return;
  store.on(["ranges", "order", "picked", "pins"], () => showFinalists(holder));
  showFinalists(holder);
}

// Keys by which rows are sorted: -1 as they come, objectives, then the columns that finalists.py tells; shares from the largest down.
function sortKey(row, order) {
  if (order < objectives.length) return row.values[order];
  const { name, form } = data.columns[order - objectives.length];
  return (row.point[name] ?? 0) * (form === "share" ? -1 : 1);
}

// A number with its interval.
const numberCell = ([value, interval]) => make("span", { class: "number" }, value, interval ? " " : null,
  interval ? make("small", { class: "interval" }, interval) : null);

function showFinalists(holder) {
  const { ranges, order, picked } = store.get();
  const rows = finalists.filter((row) => passes(row, ranges));
  if (order >= 0) rows.sort((a, b) => sortKey(a, order) - sortKey(b, order));
  const sorter = (text, definition, key) => make("button", {
    type: "button", class: "sorter", "data-tip": definition || false, "aria-pressed": String(order === key),
    onclick: () => { store.set({ order: order === key ? -1 : key }); holder.querySelectorAll(".sorter")[key]?.focus(); },
  }, text, order === key ? " ▴" : "");
  // Limited quantities have a column once they are selected by.
  const limits = dimensions.filter((entry) => entry.kind === "limit" && ranges[entry.index]);
  const head = [
    "Point",
    ...objectives.map((entry, i) => sorter(axisTitle(entry), entry.definition, i)),
    ...limits.map((entry) => term(axisTitle(entry), entry.definition)),
    ...data.columns.map((entry, k) => sorter(entry.heading, entry.meaning, objectives.length + k)),
    "State", "Pin",
  ];
  const body = rows.map((row) => [
    make("button", { type: "button", class: "picker", "aria-pressed": String(row.name === picked), "data-point": row.name,
      onclick: () => { pick(row.name); holder.querySelector('[aria-pressed="true"].picker')?.focus(); } }, wordsOf(row.name)),
    ...row.point.texts.values.map(numberCell),
    ...limits.map((entry) => make("span", { class: "number" }, row.values[entry.index] === null ? "∞" : significant(row.values[entry.index]))),
    ...row.point.texts.columns.map((text) => make("span", { class: "number" }, text)),
    [data.states[row.layer], row.point.texts.faults].filter(Boolean).join(", "),
    row.layer === "default" ? null : pinButton(row.name),
  ]);
  const table = tableOf(head, body, { class: "stacked" });
  [...table.tBodies[0].rows].forEach((line, k) => line.classList.toggle("picked", rows[k].name === picked));
  holder.replaceChildren(table);
}
