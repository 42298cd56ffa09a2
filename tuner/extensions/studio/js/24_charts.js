// Charts of an answer: its traces replace those before, in the same frames.

// The library is a file of the server, which the report has in its page.
loading = new Promise((resolve) => {
  document.head.append(make("script", { src: addressOf("/plotly.js"), async: true, onload: () => resolve(window.Plotly) }));
});

function startStudioCharts() {
  for (const element of document.querySelectorAll(".chart")) {
    const { id } = element;
    data.charts[id] ??= { traces: [], layout: {} };
    addChart(id, ["version", "off"], () => stored(id), (drawn) => {
      linkAcross(drawn);
      if (id === "front") drawn.on("plotly_click", ({ points }) => takePoint(points.map((point) => point.id).find(Boolean)));
    });
  }
}

function showCharts(answer) {
  for (const id of Object.keys(data.charts)) data.charts[id] = answer.charts[id] ?? { traces: [], layout: { meta: { hides: true } } };
  data.arrays = answer.arrays;
  byId("front").closest("figure").hidden = !answer.charts.front;
  byId("worst").textContent = answer.worst && `The loop of the setting at hand is drawn where it is worst: ${answer.worst}.`;
  decoded.clear();
  // The first flights of a moving hand; at the beginning there is nothing to move.
  if (answer.flights === studio.study.stages[0] && answer.number > 1) moveCharts();
  else store.set({ version: `${answer.number}-${answer.flights}` });
}

// A switch for each setting that is drawn.
function showLayers() {
  const layers = [["here", "here"], ["default", "default"], ...(studio.study.tunedName ? [["tuned", studio.study.tunedName]] : []),
    ...studio.pins.map((pin, i) => [`pin${i + 1}`, pin.name])];
  byId("layers").replaceChildren(...layers.map(([key, name]) => make("label", { class: "layer" },
    make("input", { type: "checkbox", checked: !store.get().off.includes(key), onchange: (event) => {
      const others = store.get().off.filter((layer) => layer !== key);
      store.set({ off: event.target.checked ? others : [...others, key] });
    } }), make("span", { class: `swatch ${key}`, "aria-hidden": "true" }), name)));
}

function fillChoice(id, names, chosen, set) {
  const choice = byId(id);
  choice.replaceChildren(...names.map((name, i) => make("option", { value: String(i), selected: i === chosen }, name)));
  choice.closest("label").hidden = names.length < 2;
  choice.onchange = () => { set(Number(choice.value)); remember(); request(); };
}

function showChoices() {
  const { scenarios, channels } = studio.study;
  fillChoice("choose-scenario", scenarios, studio.scenario, (i) => { studio.scenario = i; });
  fillChoice("choose-channel", channels, Math.max(channels.indexOf(studio.channel), 0), (i) => { studio.channel = channels[i]; });
  byId("loops").hidden = !channels.length;
}
