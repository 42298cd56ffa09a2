// Three objectives in space, turned by dragging or with the arrow keys.

function startSpace() {
  const turn = { azimuth: -1.0, height: 0.45 };
  const eye = () => ({ x: 2 * Math.cos(turn.azimuth) * Math.cos(turn.height), y: 2 * Math.sin(turn.azimuth) * Math.cos(turn.height), z: 2 * Math.sin(turn.height) });
  const made = addChart("space", SEEN, () => ({ traces: ORDER.flatMap(spaceTraces), layout: spaceLayout(eye()) }), (element) => {
    addPicking(element);
    element.on("plotly_relayout", () => {
      const { x, y, z } = element.layout.scene.camera.eye;
      Object.assign(turn, { azimuth: Math.atan2(y, x), height: Math.atan2(z, Math.hypot(x, y)) });
    });
  });
  const turned = (azimuth, height) => () => {
    turn.azimuth += azimuth;
    turn.height = Math.min(Math.max(turn.height + height, 0), 1.5);
    window.Plotly?.relayout(made.element, { "scene.camera.eye": eye() });
  };
  if (made) addKeys(made.element, () => 0, {
    ArrowLeft: turned(-0.15, 0), ArrowRight: turned(0.15, 0), ArrowUp: turned(0, 0.1), ArrowDown: turned(0, -0.1),
  });
}

const SOLID = { "triangle-up-open": "diamond-open", "x-thin": "x", "dot": "circle" };

// The marks of a layer, and a stem down to the floor below each of those that were flown.
function spaceTraces(layer) {
  const rows = rowsOf(layer, 2000).filter((row) => [0, 1, 2].every((k) => isNumber(row.values[k]) && (row.low || inSpan(row.values[k], dimensions[k]))));
  if (!rows.length) return [];
  const { ranges, picked } = store.get();
  const { marker } = data.layers[layer];
  const at = (row, k) => held(row.values[k], dimensions[k]);
  const places = (some) => ({ x: some.map((row) => at(row, 0)), y: some.map((row) => at(row, 1)), z: some.map((row) => at(row, 2)) });
  const base = { type: "scatter3d", mode: "markers", hoverinfo: "skip" };
  const mark = (some, opacity) => (some.length ? [{
    ...base, ...places(some), ids: some.map((row) => row.name), hoverinfo: "text", hovertext: some.map((row) => escaped(tellingOf(row).join("\n")).replaceAll("\n", "<br>")),
    marker: { symbol: SOLID[marker.symbol] ?? marker.symbol, size: marker.size * 0.7, color: resolved(marker.color), opacity, line: { width: 0 } }, meta: { layer },
  }] : []);
  const over = (some, look) => (some.length ? [{ ...base, ...places(some), marker: look }] : []);
  const flown = rows.filter((row) => row.low);
  const stems = { ...base, mode: "lines", line: { color: resolved(marker.color), width: 1.5 }, opacity: 0.35,
    x: flown.flatMap((row) => [at(row, 0), at(row, 0), null]), y: flown.flatMap((row) => [at(row, 1), at(row, 1), null]),
    z: flown.flatMap((row) => [at(row, 2), dimensions[2].low, null]) };
  return [
    ...(flown.length ? [stems] : []), ...mark(rows.filter((row) => passes(row, ranges)), marker.opacity), ...mark(rows.filter((row) => !passes(row, ranges)), 0.15),
    ...over(rows.filter((row) => row.point?.lost), { symbol: "x", size: 8, color: colour("bad") }),
    ...over(rows.filter((row) => row.name === picked), { symbol: "circle-open", size: 15, color: colour("ink"), line: { width: 2 } }),
    ...rows.filter((row) => pinLook(row.name)).flatMap((row) => over([row], { symbol: "circle-open", size: 13, color: resolved(pinLook(row.name).line.color), line: { width: 3 } })),
  ];
}

function spaceLayout(eye) {
  const axis = (k) => ({ title: { text: escaped(axisTitle(objectives[k])), font: { size: 11 } }, gridcolor: colour("grid"), linecolor: colour("line"), zeroline: false,
    backgroundcolor: "rgba(0,0,0,0)", nticks: 5, tickfont: { size: 10 }, ...spanLook(dimensions[k]), fixedrange: undefined });
  const scene = { xaxis: axis(0), yaxis: axis(1), zaxis: axis(2), aspectmode: "cube", camera: { eye, projection: { type: "orthographic" } }, dragmode: finger ? false : "turntable" };
  return layoutOf({ scene, margin: { l: 0, r: 0, t: 0, b: 0 } });
}
