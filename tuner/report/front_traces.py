"""Traces and axes of all figures of the front."""

from typing import Any

import numpy as np

from tuner.report.chart import COLOURS, Trace, axis, listed, marker
from tuner.report.front_layers import Layer
from tuner.report.front_ranges import Range, place
from tuner.report.results import Quantity
from tuner.report.units import bracketed

# Beyond this share of an axis a name stands to the left of its mark, where there is room.
RIGHT = 0.85


def points(layer: Layer, x: np.ndarray, y: np.ndarray, shown: Range) -> Trace:
    """Return the markers of a layer, and the name beside the two that matter; shown: the range of x."""
    trace: Trace = {
        "type": "scatter",
        "mode": "markers",
        "x": listed(x),
        "y": listed(y),
        "marker": marker(layer.kind, layer.size),
        "hovertext": layer.hover,
        "hovertemplate": "%{hovertext}<extra></extra>",
        "meta": {"layer": layer.kind},
    }
    if layer.kind in ("default", "tuned"):
        trace |= {
            "mode": "markers+text",
            "text": [layer.kind] * len(x),
            "textposition": [f"top {'left' if place(shown, value) > RIGHT else 'right'}" for value in x.tolist()],
            "cliponaxis": False,
            "textfont": {"color": COLOURS[layer.kind], "size": 13},
        }
    return trace


def reach(layer: Layer, objective: int) -> tuple[np.ndarray, np.ndarray]:
    """Return how far the intervals of an objective reach above and below the values."""
    assert layer.low is not None and layer.high is not None
    values = layer.values[:, objective]
    return layer.high[:, objective] - values, values - layer.low[:, objective]


def intervals(layer: Layer, x: np.ndarray, y: np.ndarray, bars: tuple[Any, Any]) -> Trace:
    """Return the error bars of a layer as a trace of their own, so that they can be switched off."""
    look = {"type": "data", "symmetric": False, "width": 0, "thickness": 1, "color": COLOURS[layer.kind]}
    shown = {
        f"error_{name}": {**look, "array": listed(np.maximum(up, 0.0)), "arrayminus": listed(np.maximum(down, 0.0))}
        for name, (up, down) in zip("xy", bars, strict=True)
        if up is not None
    }
    return {
        "type": "scatter",
        "mode": "markers",
        "x": listed(x),
        "y": listed(y),
        "marker": {"size": 1, "color": "rgba(0,0,0,0)"},
        "hoverinfo": "skip",
        "opacity": 0.55,
        "meta": {"layer": layer.kind, "also": "intervals"},
        **shown,
    }


def objective_axis(quantity: Quantity, shown: Range) -> dict[str, Any]:
    """Return the axis of an objective, with its unit."""
    return axis(bracketed(quantity.label, quantity.unit), **_span(shown))


def _span(shown: Range) -> dict[str, Any]:
    if shown.log:
        return {"type": "log", "range": np.log10([shown.low, shown.high]).tolist(), "dtick": "D2"}
    return {"range": [shown.low, shown.high]}
