// A search from here: the same run as `tuner run`, whose candidates appear on the trade-off as they come.

const POLL_MS = 1000;
const search = { generations: 0, timer: 0, ended: false };

async function follow() {
  window.clearTimeout(search.timer);
  const state = await answered("/search-state", { since: search.generations });
  if (state.error) { byId("search-state").textContent = state.error; return; }
  studio.study.points = { ...studio.study.points, ...state.points };
  const grown = state.generations !== search.generations || state.ended !== search.ended;
  Object.assign(search, { generations: state.generations, ended: state.ended });
  byId("search-state").textContent = state.text;
  byId("search-stop").hidden = !(state.running && state.mine);
  byId("search-start").disabled = state.running && state.mine;
  if (grown) request();
  if (state.running) search.timer = window.setTimeout(follow, POLL_MS);
}

function startSearch() {
  const folder = textField("New results folder", "from-studio");
  const from = make("select", {}, make("option", { value: "setting" }, "this setting"), make("option", { value: "study" }, "the study"));
  const start = make("button", { type: "button", id: "search-start", onclick: async () => {
    const { error, text } = await answered("/search", { ...byHand(), folder: folder.field.value, from: from.value });
    byId("search-state").textContent = error ?? text;
    if (error) return;
    search.generations = 0;
    follow();
  } }, "Search");
  const stop = make("button", { type: "button", id: "search-stop", hidden: true, onclick: async () => {
    const { text } = await answered("/search-stop", {});
    await follow();
    byId("search-state").textContent = text;
  } }, "Stop");
  byId("search").replaceChildren(make("h3", {}, "Search from here"), make("div", { class: "form-row" },
    make("label", {}, "Start from ", from), folder.row, make("div", { class: "actions" }, start, stop),
    make("p", { class: "aid", id: "search-state", role: "status" })));
  if (studio.study.live) follow();
}
