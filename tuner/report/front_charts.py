"""The trade-off: one projection for each pair of objectives, in three dimensions for three, as lines for more."""

from itertools import combinations

import numpy as np

from tuner.report.chart import COLOURS, Charts, Panel, Trace, axis, layout, listed
from tuner.report.front_layers import Layer, layers
from tuner.report.front_lines import add_lines
from tuner.report.front_ranges import Range, shown_range
from tuner.report.front_space import add_space
from tuner.report.front_traces import intervals, objective_axis, points, reach
from tuner.report.results import Results

# Projections drawn at most: those of six objectives.
MOST_PAIRS = 15


def add_front(results: Results, charts: Charts) -> list[Panel]:
    """Add the figures of the front and return their panels in reading order."""
    found, count = layers(results, charts), len(results.objectives)
    ranges = [shown_range(results.front, i) for i in range(count)]
    if count == 1:
        return [_ranking(results, charts, found, ranges[0])]
    panels = []
    if count == 3:
        panels.append(add_space(results, charts, found, ranges))
    if count > 3:
        panels.append(add_lines(results, charts, found))
    for i, j in list(combinations(range(count), 2))[:MOST_PAIRS]:
        panels.append(_pair(results, charts, found, ranges, (i, j)))
    return panels


def _pair(results: Results, charts: Charts, found: list[Layer], ranges: list[Range], pair: tuple[int, int]) -> Panel:
    i, j = pair
    name, (x, y) = f"front-{i}-{j}", (results.objectives[i], results.objectives[j])
    traces = [_staircase(results)] if len(results.objectives) == 2 else []
    for layer in found:
        traces.append(points(layer, layer.values[:, i], layer.values[:, j], ranges[i]))
        if layer.low is not None and layer.high is not None:
            bars = (reach(layer, i), reach(layer, j))
            traces.append(intervals(layer, layer.values[:, i], layer.values[:, j], bars))
    charts.add(name, traces, layout(objective_axis(x, ranges[i]), objective_axis(y, ranges[j])))
    return Panel(name, "pair", f"{y.label} over {x.label}")


def _staircase(results: Results) -> Trace:
    """Return the boundary of what the front of two objectives dominates."""
    values = results.front.held_out[results.front.non_dominated]
    values = values[np.argsort(values[:, 0], kind="stable")]
    return {
        "type": "scatter",
        "mode": "lines",
        "x": listed(values[:, 0]),
        "y": listed(values[:, 1]),
        "line": {"shape": "hv", "width": 1, "dash": "dot", "color": COLOURS["front"]},
        "hoverinfo": "skip",
        "meta": {"layer": "front"},
    }


def _ranking(results: Results, charts: Charts, found: list[Layer], shown: Range) -> Panel:
    """One objective: the points in order, the best on top."""
    order = np.argsort(results.front.held_out[:, 0], kind="stable")
    place = {name: float(len(order) - rank) for rank, name in enumerate(np.array(results.front.points)[order])}
    traces = []
    for layer in found:
        if layer.low is None:
            continue
        heights = np.array([place[name] for name in layer.names])
        traces.append(points(layer, layer.values[:, 0], heights, shown))
        traces.append(intervals(layer, layer.values[:, 0], heights, (reach(layer, 0), (None, None))))
    y = axis("", tickvals=list(place.values()), ticktext=list(place), nticks=0, showgrid=False)
    charts.add("front-ranking", traces, layout(objective_axis(results.objectives[0], shown), y))
    return Panel("front-ranking", "ranking", results.objectives[0].label)
