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
  const result = make("p", { class: "aid", role: "status" });
  const button = make("button", { type: "button", onclick: async () => {
    button.disabled = true;
    result.textContent = "…";
    const { error, text } = await run();
    result.textContent = error ?? text;
    result.classList.toggle("broken", Boolean(error));
    button.disabled = false;
  } }, title);
  return make("div", { class: "form-row" }, ...parts, make("div", { class: "actions" }, button), result);
}

function startOut() {
  const file = textField("File", "gains.json");
  byId("out").replaceChildren(outForm("Save gains", [file.row], () => answered("/save", { ...byHand(), file: file.field.value })));
}

function takePoint(name) {
  const point = name && studio.study.points?.[name];
  if (point) takeOver(point);
}
