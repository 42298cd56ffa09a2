// gains.json of any finalist. Of the recommended one it is the file of the folder, byte for byte.

// What a document says of the recommended point alone: its hash, its margins, what was done with it later.
const OWN = ["sha256", "margins", "cost", "exports"];

// The document of a point: that of the recommended one with this point's gains and held-out values, but without the steady state
// in which a margin of the recommended one is worst.
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
  made.objectives = (made.objectives ?? []).map(({ state, ...row }) =>
    ({ ...row, ...point.patch.find((entry) => entry.kind === row.kind && entry.label === row.label) }));
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
