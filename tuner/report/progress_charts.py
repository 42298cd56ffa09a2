"""How the search went: hypervolume and share of feasible candidates by generation."""

import numpy as np

from tuner.report.chart import Charts, Panel, Trace, axis, layout, listed
from tuner.report.numbers import count, duration
from tuner.report.results import Results


def add_progress(results: Results, charts: Charts) -> list[Panel]:
    """Add both figures and return their panels."""
    history = results.history
    when = [
        f"generation {count(generation)}, {count(flights)} flights, {duration(seconds)}"
        for generation, flights, seconds in zip(history.generation, history.flights, history.seconds, strict=True)
    ]
    hover = charts.share("hover-progress", when)
    shown = (
        ("progress-hypervolume", "Hypervolume [share of the box]", history.hypervolume, "tuned", "circle", {}),
        ("progress-feasible", "Feasible candidates [%]", 100.0 * history.feasible_share, "front", "square",
         {"range": [-4, 104]}),
    )  # fmt: skip
    panels = []
    for name, title, values, colour, symbol, span in shown:
        trace = _line(history.generation, values, f"@{colour}", symbol, hover)
        charts.add(name, [trace], layout(axis("generation"), axis("", **span)))
        panels.append(Panel(name, "progress", title))
    return panels


def _line(x: np.ndarray, y: np.ndarray, colour: str, symbol: str, hover: str) -> Trace:
    return {
        "type": "scatter",
        "mode": "lines+markers",
        "x": listed(x),
        "y": listed(y),
        "line": {"width": 1.8, "color": colour},
        "marker": {"size": 5, "symbol": symbol, "color": colour},
        "hovertext": hover,
        "hovertemplate": "%{y:.4~g}<br>%{hovertext}<extra></extra>",
    }
