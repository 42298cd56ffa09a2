// Time responses of the picked point: median and 5 to 95 % of the flights, its worst flight, the reference, the default behind.

const responses = data.responses;

// Series of numbers out of sixteen bits: low + step * q.
function unpacked({ scale: [low, step], packed }) {
  return Float64Array.from(new Uint16Array(bytesOf(packed)), (q) => low + step * q);
}

const fansDecoded = new Map();

// Series of one point in one scenario: [{ low, median, high, ... } for each signal], null where nothing is known of it.
function fansOf(scenario, name) {
  const key = JSON.stringify([scenario, name]);
  if (!fansDecoded.has(key)) fansDecoded.set(key, decodedFans(responses.scenarios[scenario].fans[name]));
  return fansDecoded.get(key);
}

function decodedFans(fans) {
  if (!fans) return null;
  return fans.signals.map(({ scale, series, packed }) => {
    const all = unpacked({ scale, packed });
    const count = all.length / series.length;
    return Object.fromEntries(series.map((name, k) => [name, all.subarray(k * count, (k + 1) * count)]));
  });
}

function startResponses() {
  if (!responses) return;
  const choice = byId("choose-scenario");
  choice?.addEventListener("change", () => store.set({ scenario: Number(choice.value) }));
  byId("behind")?.addEventListener("change", (event) => store.set({ behind: event.target.checked }));
  responses.signals.forEach((signal, k) =>
    addPlot(`response-${k}`, ["picked", "scenario", "behind"], () => responseFigure(signal, k)));
  linkAcross("response-");
  store.on(["picked", "scenario"], tellResponses);
  tellResponses();
}

function tellResponses() {
  const { picked, scenario } = store.get();
  const fans = responses.scenarios[scenario].fans[picked];
  byId("responses-of").textContent = fans
    ? `${picked} in ${responses.scenarios[scenario].name}${fans.flight == null ? "" : `; its worst flight is number ${fans.flight}`}`
    : `No responses of ${picked} are kept; ${Object.keys(responses.scenarios[scenario].fans).length} other points have them.`;
}

function responseFigure(signal, k) {
  const { picked, scenario, behind } = store.get();
  const known = responses.scenarios[scenario];
  const time = (known.seconds ??= Array.from(singles(known.time)));
  const names = [...new Set([...(behind ? ["default"] : []), picked])].filter((name) => known.fans[name]);
  const fans = names.map((name) => [name, fansOf(scenario, name)?.[k]]).filter(([, fan]) => fan);
  if (!fans.length) return null;
  const traces = fans.flatMap(([name, fan]) => band(name, fan, time));
  const own = fans[fans.length - 1][1].reference;
  const reference = own ?? (known.references[signal.name] && unpacked(known.references[signal.name]));
  if (reference) traces.push(lineOf("reference", time, reference, { dash: "2px,3px", width: 1.3, color: colour("muted") }));
  const worst = fans[fans.length - 1][1].worst;
  if (worst) traces.push(lineOf("worst flight", time, worst, { dash: "7px,2px,2px,2px", width: 1, color: colour("bad") }));
  traces.push(...fans.map(([name, fan]) => median(name, fan, time)));
  const span = signal.range ? { range: signal.range } : {};
  return { traces, layout: layoutOf(axisLook("time [s]"), axisLook("", span), { hovermode: "x" }) };
}

const roleOf = (name) => (name === "default" ? "default" : "tuned");

// Lower and upper edge, filled in between; they must stay neighbours.
function band(name, fan, time) {
  const edge = { type: "scatter", mode: "lines", x: time, line: { width: 0 }, hoverinfo: "skip" };
  const fill = { fill: "tonexty", fillcolor: faded(roleOf(name), 0.2) };
  return [{ ...edge, y: Array.from(fan.low) }, { ...edge, y: Array.from(fan.high), ...fill }];
}

function median(name, fan, time) {
  const role = roleOf(name);
  return {
    type: "scatter", mode: "lines", x: time, y: Array.from(fan.median),
    line: { width: 1.8, color: colour(role), dash: role === "default" ? "6px,3px" : "solid" },
    customdata: time.map((_, i) => [fan.low[i], fan.high[i]]),
    hovertemplate: `${escaped(name)}: %{y:.3~f} [%{customdata[0]:.3~f}, %{customdata[1]:.3~f}]<extra></extra>`,
  };
}

const lineOf = (name, x, y, line) =>
  ({ type: "scatter", mode: "lines", x, y: Array.from(y), line, hovertemplate: `${name}: %{y:.3~f}<extra></extra>` });
