// What leaves the page: files in the folder of the command, with the server's refusals as text.

async function answered(path, content) {
  try {
    const response = await post(path, content);
    if (response.headers.get("content-type")?.startsWith("application/json")) return await response.json();
    let last = { error: "The server gave no answer." };
    for await (const message of linesOf(response)) {
      if (message.progress !== undefined) say(message.progress);
      else last = message;
    }
    say("");
    return last;
  } catch { return { error: "The studio has ended, or cannot be reached." }; }
}

function textField(label, value, attributes = {}) {
  const field = make("input", { class: "text-field", type: "text", value, ...attributes });
  return { field, row: make("label", {}, label, field) };
}

// A form with one button: its answer, or its refusal, is shown below it.
function outForm(title, parts, run) {
  const result = make("div", { class: "aid", role: "status" });
  const button = make("button", { type: "button", onclick: async () => {
    button.disabled = true;
    result.textContent = "…";
    const { error, text, lines = [] } = await run();
    result.replaceChildren(make("p", { class: error ? "broken" : "" }, error ?? text), ...(lines.length ? [make("ul", {}, lines.map((each) => make("li", {}, each)))] : []));
    button.disabled = false;
  } }, title);
  return make("div", { class: "form-row" }, ...parts, make("div", { class: "actions" }, button), result);
}

const outFields = { save: ["file", "gains.json", "File"], study: ["file", "tuned.toml", "Study file"], judge: ["folder", "opinion", "Folder"] };

// A form with one field: save, study or judge.
function simpleForm(name, title) {
  const [key, value, label] = outFields[name];
  const { field, row } = textField(label, value);
  return outForm(title, [row], () => answered(`/${name}`, { ...byHand(), [key]: field.value }));
}

function exportForm() {
  const { targets } = studio.study;
  const folder = textField("Folder", `export-${targets[0]}`);
  const choice = make("select", { onchange: () => { folder.field.value = `export-${choice.value}`; } }, targets.map((name) => make("option", {}, name)));
  return outForm("Export", [make("label", {}, "Target ", choice), folder.row],
    () => answered("/export", { ...byHand(), target: choice.value, folder: folder.field.value }));
}

function startOut() {
  byId("out").replaceChildren(...[
    make("p", { class: "aid" }, `Files go into ${studio.study.folder}.`),
    simpleForm("save", "Save gains"), exportForm(), simpleForm("study", "Save as a study"),
    studio.study.judges ? simpleForm("judge", "Judge against the present file") : null,
    outForm("Compare on new flights", [], () => answered("/compare", byHand())),
  ].filter(Boolean));
}

function takePoint(name) {
  const point = name && studio.study.points?.[name];
  if (point) takeOver(point);
}
