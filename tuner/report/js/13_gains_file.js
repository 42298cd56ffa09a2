// gains.json of any finalist. Of the recommended one it is the file of the folder, byte for byte.

const estimateOf = (value, low, high) => ({ value, low, high });

// What the held-out flights say of a point, row by row in the shape of the recommended point's, values as stored.
function judged(row, point) {
  const nothing = estimateOf(null, null, null);
  const plain = byName.get("default")?.point ?? null;
  if (row.kind === "requirement") {
    const i = data.requirements.findIndex((entry) => entry.label === row.label);
    const [value, before] = [point.requirements[i] ?? null, plain?.requirements[i] ?? null];
    const apart = isNumber(value) && isNumber(before) ? value - before : null;
    return [estimateOf(before, null, null), estimateOf(value, null, null), estimateOf(apart, null, null)];
  }
  if (row.kind === "constraint") {
    const i = data.constraints.findIndex((entry) => entry.label === row.label);
    const [mine, its] = [point.constraints[i], plain?.constraints[i]];
    return mine ? [its ? estimateOf(...its.slice(0, 3)) : nothing, estimateOf(...mine.slice(0, 3)), estimateOf(...mine.slice(3))]
      : [nothing, nothing, nothing];
  }
  const i = objectives.findIndex((entry) => entry.label === row.label);
  const told = (of) => (of ? estimateOf(of.held_out[i], of.low[i], of.high[i]) : nothing);
  const apart = point.difference ? estimateOf(point.difference[i], point.difference_low[i], point.difference_high[i]) : nothing;
  return [told(plain), told(point), apart];
}

function verdictOf({ kind, limit, sense }, value, apart) {
  if (kind === "objective") {
    if (!isNumber(apart.low)) return "not known";
    return apart.high < 0 ? "better" : apart.low > 0 ? "worse" : "no clear difference";
  }
  // A requirement without a value is infinite: that keeps "at least" and breaks "at most".
  if (!isNumber(value)) return kind === "requirement" ? (sense === "least" ? "kept" : "broken") : "not known";
  return (sense === "least" ? value >= limit : value <= limit) ? "kept" : "broken";
}

const senseOf = (row) => data.requirements.find((entry) => entry.label === row.label && row.kind === "requirement")?.sense;

// What a document says of the recommended point alone: its hash, its margins, what was done with it later.
const OWN = ["sha256", "margins", "cost", "exports"];

// The document of a point: that of the recommended one with this point's gains and held-out values.
function gainsDocument(point) {
  const made = JSON.parse(data.gains_file);
  for (const key of OWN) delete made[key];
  variables.forEach((entry, i) => {
    for (const address of entry.addresses) if (made.gains[address]) made.gains[address].value = point.gains[i];
  });
  if (made.study) {
    made.study.point = point.name;
    if (point.feasible) delete made.study.feasible;
    else made.study.feasible = false;
  }
  made.objectives = (made.objectives ?? []).map((row) => {
    const [plain, tuned, difference] = judged(row, point);
    const verdict = verdictOf({ ...row, sense: senseOf(row) }, tuned.value, difference);
    return { ...row, default: plain, tuned, difference, verdict };
  });
  return made;
}

const gainsText = (name) =>
  (name === data.tuned ? data.gains_file : `${JSON.stringify(gainsDocument(byName.get(name).point), null, 2)}\n`);

function saveGains(name) {
  const address = URL.createObjectURL(new Blob([gainsText(name)], { type: "application/json" }));
  const link = make("a", { href: address, download: name === data.tuned ? data.gains_name : `gains-${name}.json` });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}

async function copyText(text, button) {
  const before = button.textContent;
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    // A page opened from disk may not write to the clipboard directly: copy what is selected in a field.
    const field = make("textarea", { class: "hidden" });
    field.value = text;
    document.body.append(field);
    field.select();
    document.execCommand("copy");
    field.remove();
  }
  button.textContent = "Copied";
  setTimeout(() => { button.textContent = before; }, 2000);
}
