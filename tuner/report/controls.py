"""Switches of the layers of points: native checkboxes with the symbol of each layer, so that keys reach them."""

import numpy as np

from tuner.documents.tuning import DEFAULT, TuningFolder
from tuner.report.charts.front import LAYERS, layer_of
from tuner.report.charts.look import LOST, Look, symbol
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import count
from tuner.text.sentences import counted

LOST_WORDS = "failed flights when held out"
BEYOND = "off-scale in this direction"
HIDDEN = ("searched", "infeasible")
"""Layers that are not shown at first: what the search tried."""


def layer_switches(results: TuningFolder) -> Markup:
    """Return checkboxes for layers and intervals."""
    sizes = layer_sizes(results)
    boxes = [
        _switch(kind, look, results.called if kind == "tuned" else label, sizes[kind])
        for kind, (label, look) in reversed(LAYERS.items())
        if sizes[kind]
    ]
    lost = results.held_out_front.lost
    if lost.any():
        points, flights = int((lost > 0).sum()), int(lost.sum())
        description = f" {LOST_WORDS} ({counted(points, 'point')}, {counted(flights, 'flight')})"
        boxes.append(element("span", symbol(LOST), description, class_="switch", id="lost-legend"))
    beyond = Look("front", "triangle-up")
    boxes.append(element("span", symbol(beyond), f" {BEYOND}", class_="switch", id="beyond-legend", hidden=True))
    boxes.append(_switch("intervals", Look("muted", "cross-thin"), "95 % intervals"))
    return element("fieldset", element("legend", "Show", class_="hidden"), *boxes, class_="controls", id="layers")


def layer_sizes(results: TuningFolder) -> dict[str, int]:
    """Return the number of points of each layer."""
    front, tried = results.held_out_front, results.evaluated
    flown = front.candidates[[role != DEFAULT for role in front.roles]]
    layers = [layer_of(front, row) for row in range(len(front.points))]
    return {
        **{layer: layers.count(layer) for layer in LAYERS},
        "start": int((tried.number == results.start).sum()) if results.start is not None else 0,
        "searched": int((tried.feasible & ~np.isin(tried.number, flown)).sum()),
        "infeasible": int((~tried.feasible).sum()),
    }


def _switch(kind: str, look: Look, label: str, size: int = 1) -> Markup:
    label += f" ({count(size)})" if size > 1 else ""
    box = element("input", type="checkbox", checked=kind not in HIDDEN, data_layer=kind)
    return element("label", box, join((symbol(look), f" {label}")), class_="switch")
