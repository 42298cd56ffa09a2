"""The fronts of all contenders over each other, a figure for each pair of objectives, with intervals and gains on hover."""

from html import escape
from itertools import combinations
from typing import Any

import numpy as np

from tuner.documents.contest import Contest, Front, Fronts, Gain
from tuner.documents.look import Look, plotly_line, plotly_marker
from tuner.report.chart import Charts, Panel, Trace, axis, layout, listed
from tuner.report.contest.joined_gains import joined
from tuner.report.contest.spans import Span, span_of
from tuner.report.prose import counted
from tuner.text.numbers import estimate, significant
from tuner.text.units import bracketed, plain

# Projections drawn at most: those of five objectives.
MOST_PAIRS = 10
# Fronts are much like hyperbolas: they stand apart on logarithmic axes, and huddle in a corner of others.
LOG_FACTOR = 5.0
# Where the names of recommended points stand, one contender after the other: such points are often neighbours.
PLACES = ("top right", "bottom left", "bottom right", "top left")


def add_fronts(contest: Contest, fronts: Fronts, charts: Charts) -> list[Panel]:
    """Add the figures and return their panels; one objective is shown as a ranking of points."""
    hovers = {front.contender: _share_hover(contest, fronts, front, charts) for front in fronts.fronts}
    count = len(fronts.objectives)
    if count == 1:
        return [_ranking(contest, fronts, charts, hovers)]
    panels = []
    for i, j in list(combinations(range(count), 2))[:MOST_PAIRS]:
        traces = []
        for front in fronts.fronts:
            traces += _pair(contest, front, (i, j), hovers[front.contender], staircase=count == 2)
        name = f"front-{i}-{j}"
        charts.add(name, traces, layout(_axis(contest, fronts, i), _axis(contest, fronts, j)))
        panels.append(Panel(name, "pair", f"{fronts.objectives[j]} over {fronts.objectives[i]}"))
    return panels


def objective_span(fronts: Fronts, objective: int) -> Span:
    """Return the part of an objective's axis that holds all fronts with their intervals."""
    parts = [part[:, objective] for front in fronts.fronts for part in (front.values, front.low, front.high)]
    return span_of(parts, LOG_FACTOR)


def reach(front: Front, objective: int) -> np.ndarray:
    """Return how far the intervals reach below and above the values, (2, n)."""
    value = front.values[:, objective]
    ends = np.stack([value - front.low[:, objective], front.high[:, objective] - value], axis=0)
    return np.maximum(ends, 0.0)


def stairs(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (n,) in the order of x, between which the boundary of what they dominate runs in steps."""
    order = np.argsort(x, kind="stable")
    return x[order], y[order]


def hover_texts(contest: Contest, fronts: Fronts, front: Front) -> list[str]:
    """Return the text under the pointer of each point: values with intervals, and gains."""
    contender = contest.contenders[contest.index[front.contender]]
    units = {gain.address: gain.unit for gain in contender.gains}
    texts = []
    for row, point in enumerate(front.points):
        mark = ", recommended" if front.recommended[row] else ""
        mark += f", lost {counted(int(front.lost[row]), 'flight')}" if front.lost[row] else ""
        lines = [f"<b>{escape(front.contender)} {escape(point)}</b>{mark}"]
        for i, label in enumerate(fronts.objectives):
            middle, low, high = (float(part[row, i]) for part in (front.values, front.low, front.high))
            value, ends = estimate(middle, low, high)
            lines.append(escape(f"{label}: {value} {ends} {plain(contest.quantity[label].unit)}"))
        gains = joined([Gain(name, value, units.get(name, "1")) for name, value in front.gains[row].items()])
        lines += [escape(f"{gain.address} = {significant(gain.value)}") for gain in gains]
        texts.append("<br>".join(lines))
    return texts


def _share_hover(contest: Contest, fronts: Fronts, front: Front, charts: Charts) -> str:
    return charts.share(f"hover-{contest.layer(front.contender)}", hover_texts(contest, fronts, front))


def _axis(contest: Contest, fronts: Fronts, objective: int) -> dict[str, Any]:
    label = fronts.objectives[objective]
    return axis(bracketed(label, contest.quantity[label].unit), **objective_span(fronts, objective).plotly())


def _pair(contest: Contest, front: Front, pair: tuple[int, int], hover: str, staircase: bool) -> list[Trace]:
    look, meta = contest.look[front.contender], {"layer": contest.layer(front.contender)}
    x, y = (front.values[:, k] for k in pair)
    traces = [_staircase(x, y, look, meta)] if staircase and len(x) > 1 else []
    bars = {f"error_{name}": _bars(front, k, look) for name, k in zip("xy", pair, strict=True)}
    traces.append(
        {
            "type": "scatter", "mode": "markers", "x": listed(x), "y": listed(y), "hoverinfo": "skip", "opacity": 0.5,
            "marker": {"size": 1, "color": "rgba(0,0,0,0)"}, **bars, "meta": {**meta, "also": "intervals"},
        }
    )  # fmt: skip
    traces.append(_points(x, y, look, hover, meta))
    traces += _crosses(x[front.lost > 0], y[front.lost > 0], meta)
    chosen = front.recommended
    if chosen.any():
        place = PLACES[contest.index[front.contender] % len(PLACES)]
        traces.append({**_ring(front.contender, x[chosen], y[chosen], look, meta), "textposition": place})
    return traces


def _staircase(x: np.ndarray, y: np.ndarray, look: Look, meta: dict[str, str]) -> Trace:
    across, up = stairs(x, y)
    line = {**plotly_line(look, 1.4), "shape": "hv"}
    shown = {"type": "scatter", "mode": "lines", "x": listed(across), "y": listed(up)}
    return {**shown, "line": line, "hoverinfo": "skip", "meta": meta}


def _points(x: np.ndarray, y: np.ndarray, look: Look, hover: str, meta: dict[str, str]) -> Trace:
    shown = {"type": "scatter", "mode": "markers", "x": listed(x), "y": listed(y), "marker": plotly_marker(look, 9)}
    return {**shown, "hovertext": hover, "hovertemplate": "%{hovertext}<extra></extra>", "meta": meta}


def _crosses(x: np.ndarray, y: np.ndarray, meta: dict[str, str]) -> list[Trace]:
    """Return a cross over each point that lost flights."""
    marker = {"symbol": "x-thin", "size": 12, "line": {"width": 2, "color": "@bad"}}
    shown = {"type": "scatter", "mode": "markers", "x": listed(x), "y": listed(y), "hoverinfo": "skip"}
    return [{**shown, "marker": marker, "meta": meta}] if len(x) else []


def _bars(front: Front, objective: int, look: Look) -> dict[str, Any]:
    down, up = reach(front, objective)
    bars = {"type": "data", "symmetric": False, "width": 0, "thickness": 1, "color": look.variable}
    return {**bars, "array": listed(up), "arrayminus": listed(down)}


def _ring(name: str, x: np.ndarray, y: np.ndarray, look: Look, meta: dict[str, str]) -> Trace:
    """Return the recommended point: a ring around its mark and the contender's name beside it."""
    return {
        "type": "scatter", "mode": "markers+text", "x": listed(x), "y": listed(y), "hoverinfo": "skip", "meta": meta,
        "marker": {"symbol": "circle-open", "size": 20, "color": "@ink", "line": {"width": 1.8, "color": "@ink"}},
        "text": [escape(name, quote=False)] * len(x), "cliponaxis": False,
        "textfont": {"color": look.variable, "size": 13},
    }  # fmt: skip


def _ranking(contest: Contest, fronts: Fronts, charts: Charts, hovers: dict[str, str]) -> Panel:
    """One objective: a row of points for each contender, the best to the left."""
    names = [front.contender for front in fronts.fronts]
    traces = []
    for row, front in enumerate(fronts.fronts):
        look, meta = contest.look[front.contender], {"layer": contest.layer(front.contender)}
        height = np.full(len(front.points), float(len(names) - row))
        points = _points(front.values[:, 0], height, look, hovers[front.contender], meta)
        traces.append({**points, "error_x": _bars(front, 0, look)})
        traces += _crosses(front.values[front.lost > 0, 0], height[front.lost > 0], meta)
    ticks = {"tickvals": list(range(len(names), 0, -1)), "ticktext": [escape(name, quote=False) for name in names]}
    y = axis("", **ticks, nticks=0, range=[0.4, len(names) + 0.6])
    charts.add("front-ranking", traces, layout(_axis(contest, fronts, 0), y))
    return Panel("front-ranking", "pair", fronts.objectives[0])
