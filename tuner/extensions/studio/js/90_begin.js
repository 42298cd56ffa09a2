// Opens the study, then wires the page.

function show(answer, begin) {
  complain("");
  byId("summary").textContent = answer.summary;
  say(answer.last ? "" : `${answer.flights} ${studio.study.noun}; more follow while the setting rests.`);
  showNumbers(answer);
  showCharts(answer);
  if (answer.last) announce(answer.summary);
  // Charts are drawn in the next frame; the number is set when that has been painted.
  requestAnimationFrame(() => requestAnimationFrame(() => {
    const { dataset } = document.documentElement;
    dataset.answered = String(answer.number);
    dataset.flights = String(answer.flights);
    if (answer.last && answer.number === talk.number && !talk.dirty) dataset.rest = "yes";
    if (answer.flights === studio.study.stages[0]) dataset.latency = String(Math.round(performance.now() - begin));
  }));
}

function showAll() {
  studio.study.gains.forEach(showGain);
  showPins();
  showLayers();
  showChoices();
  showHistory();
}

async function begin() {
  try {
    const response = await post("/open", {});
    for await (const message of linesOf(response)) {
      if (message.progress !== undefined) say(message.progress);
      else if (message.error !== undefined) complain(message.error);
      else studio.study = message;
    }
  } catch { complain("The studio has ended, or cannot be reached. Start it again with `tuner studio`."); }
  if (!studio.study) return;
  studio.values = allOf("start");
  studio.channel = studio.study.channels[0] ?? "";
  studio.pins = studio.study.pins;
  decode(window.location.hash);
  startGains();
  startDesign();
  showAll();
  startOut();
  startSearch();
  startTips();
  startStudioCharts();
  remember();
  request();
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { palette = {}; for (const chart of charts) chart.refresh(); });
  window.addEventListener("hashchange", () => { decode(window.location.hash); showAll(); remember(); request(); });
  document.documentElement.dataset.ready = "yes";
}

begin();
