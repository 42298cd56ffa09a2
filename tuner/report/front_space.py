"""The front of three objectives in three dimensions (WebGL); the projections beside it say the same without."""

import numpy as np

from tuner.report.chart import Charts, Panel, base, listed, marker
from tuner.report.front_layers import Layer
from tuner.report.front_ranges import Range
from tuner.report.front_traces import objective_axis
from tuner.report.results import Results


def add_space(results: Results, charts: Charts, found: list[Layer], ranges: list[Range]) -> Panel:
    """Add the figure and return its panel."""
    traces = []
    for layer in found:
        # WebGL draws what lies outside the box as well: leave it out.
        inside = np.all([(v >= r.low) & (v <= r.high) for v, r in zip(layer.values.T, ranges, strict=True)], axis=0)
        hover = [text for text, keep in zip(charts.shared[layer.hover[1:]], inside, strict=True) if keep]
        traces.append(
            {
                "type": "scatter3d",
                "mode": "markers",
                **{name: listed(values) for name, values in zip("xyz", layer.values[inside].T, strict=True)},
                "marker": marker(layer.kind, 0.5 * layer.size, space=True),
                "hovertext": charts.share(f"{layer.hover[1:]}-space", hover),
                "hovertemplate": "%{hovertext}<extra></extra>",
                "meta": {"layer": layer.kind},
            }
        )
    axes = {}
    for name, quantity, shown in zip("xyz", results.objectives, ranges, strict=True):
        entry = objective_axis(quantity, shown)
        del entry["automargin"], entry["title"]["standoff"]
        axes[f"{name}axis"] = {**entry, "showbackground": False, "tickfont": {"size": 10}}
        axes[f"{name}axis"]["title"]["font"] = {"size": 11}
    scene = {**axes, "aspectmode": "cube", "camera": {"eye": {"x": 1.6, "y": 1.6, "z": 0.9}}}
    charts.add("front-space", traces, {**base(), "scene": scene, "margin": {"l": 0, "r": 0, "t": 0, "b": 0}})
    return Panel("front-space", "space", "All three objectives")
