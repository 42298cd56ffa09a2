"""Parallel coordinates of four and more objectives: a line a point, each objective in units of the default's value."""

from html import escape

import numpy as np

from tuner.report.chart import COLOURS, DASHES, Charts, Panel, Trace, axis, layout, listed, marker
from tuner.report.front_layers import Layer
from tuner.report.results import Results


def add_lines(results: Results, charts: Charts, found: list[Layer]) -> Panel:
    """Add the figure and return its panel."""
    rows = results.front.of("default")
    held_out = results.front.held_out
    reference = held_out[rows[0]] if rows else np.nanmax(held_out, axis=0)
    reference = np.where(reference > 0.0, reference, 1.0)
    names = [escape(quantity.label, quote=False) for quantity in results.objectives]
    traces: list[Trace] = []
    for layer in found:
        if layer.low is None:
            continue
        thick = layer.kind in ("default", "tuned")
        for values, text in zip(layer.values / reference, charts.shared[layer.hover[1:]], strict=True):
            traces.append(
                {
                    "type": "scatter",
                    "mode": "lines+markers",
                    "x": names,
                    "y": listed(values),
                    "line": {
                        "width": 2.5 if thick else 1,
                        "color": COLOURS[layer.kind] if thick else "@front/0.45",
                        "dash": DASHES.get(layer.kind, "solid"),
                    },
                    "marker": marker(layer.kind, layer.size if thick else 4),
                    "hovertext": text,
                    "hovertemplate": "%{hovertext}<extra></extra>",
                    "meta": {"layer": layer.kind},
                }
            )
    y = axis("value ÷ value of the default")
    x = axis("", type="category", nticks=0, tickangle=0, showgrid=True)
    charts.add("front-lines", traces, layout(x, y))
    return Panel("front-lines", "lines", "All objectives in units of the default's values")
