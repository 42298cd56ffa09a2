// The finalists as a table: those selected, in the order that the reader chooses.

function startFinalists() {
  const holder = byId("finalists");
  if (!holder) return;
  store.on(["ranges", "order", "picked"], () => showFinalists(holder));
  showFinalists(holder);
}

// Keys by which rows are sorted: -1 as they come, objectives, then the share of resamples.
const sortKey = (row, order) => (order < objectives.length ? row.values[order] : -(row.point.probability ?? 0));

function showFinalists(holder) {
  const { ranges, order, picked } = store.get();
  const rows = finalists.filter((row) => passes(row, ranges));
  if (order >= 0) rows.sort((a, b) => sortKey(a, order) - sortKey(b, order));
  const sorter = (text, definition, key) => make("button", {
    type: "button", class: "sorter", "data-tip": definition || false, "aria-pressed": String(order === key),
    onclick: () => { store.set({ order: order === key ? -1 : key }); holder.querySelectorAll(".sorter")[key]?.focus(); },
  }, text, order === key ? " ▴" : "");
  const head = [
    "Point",
    ...objectives.map((entry, i) => sorter(axisTitle(entry), entry.definition, i)),
    sorter("Non-dominated", "share of the resamples of the held-out scenarios on which the point is non-dominated among all finalists",
      objectives.length),
    "State",
  ];
  const body = rows.map((row) => [
    make("button", { type: "button", class: "picker", "aria-pressed": String(row.name === picked), "data-point": row.name,
      onclick: () => { pick(row.name); holder.querySelector('[aria-pressed="true"].picker')?.focus(); } }, row.name),
    ...objectives.map((_, i) => {
      const [value, interval] = estimate(row.values[i], row.low[i], row.high[i]);
      return make("span", { class: "number" }, value, " ", make("small", { class: "interval" }, interval));
    }),
    make("span", { class: "number" }, row.layer === "default" ? MISSING : perCent(row.point.probability)),
    [STATES[row.layer], faultsOf(row)].filter(Boolean).join(", "),
  ]);
  const table = tableOf(head, body, { class: "stacked" });
  [...table.tBodies[0].rows].forEach((line, k) => line.classList.toggle("picked", rows[k].name === picked));
  holder.replaceChildren(table);
}
