"""Which layers of points are shown: native checkboxes with the symbol of each layer, so that keys reach them."""

import numpy as np

from tuner.documents.results import DEFAULT, TUNED, Results
from tuner.report.drawings import diamond, square
from tuner.report.prose import counted
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import count

LAYERS = {
    "tuned": "",
    "default": "default",
    "front": "front, held-out",
    "finalist": "off the front when held out",
    "start": "design start, search values",
    "searched": "other candidates, search values",
    "infeasible": "limit broken, search values",
}
LOST = "lost flights when held out"
BEYOND = "at the edge: beyond the axes, that way"


def layer_switches(results: Results) -> Markup:
    """Return a checkbox for each layer that has points, and one for the intervals; what the search tried is off at first."""
    sizes = layer_sizes(results)
    boxes = [
        _switch(kind, join((icon(kind), f" {label}", f" ({count(sizes[kind])})" if sizes[kind] > 1 else "")))
        for kind, label in {**LAYERS, "tuned": results.called}.items()
        if sizes[kind]
    ]
    lost = results.front.lost
    if lost.any():
        points, flights = int((lost > 0).sum()), int(lost.sum())
        said = f" {LOST} ({counted(points, 'point')}, {counted(flights, 'flight')})"
        boxes.append(element("span", icon("lost"), said, class_="switch", id="lost-legend"))
    boxes.append(element("span", icon("beyond"), f" {BEYOND}", class_="switch", id="beyond-legend", hidden=True))
    boxes.append(_switch("intervals", join((icon("intervals"), " 95 % intervals"))))
    return element("fieldset", element("legend", "Show", class_="hidden"), *boxes, class_="controls", id="layers")


def layer_sizes(results: Results) -> dict[str, int]:
    """Return how many points each layer has."""
    front, tried = results.front, results.candidates
    named = np.array([role in (DEFAULT, TUNED) for role in front.roles])
    start = int((tried.number == results.start).sum()) if results.start is not None else 0
    flown = front.candidates[[role != DEFAULT for role in front.roles]]
    return {
        "tuned": len(front.of(TUNED)),
        "default": len(front.of(DEFAULT)),
        "front": int((front.non_dominated & ~named).sum()),
        "finalist": int((~front.non_dominated & ~named).sum()),
        "start": start,
        "searched": int((tried.feasible & ~np.isin(tried.number, flown)).sum()),
        "infeasible": int((~tried.feasible).sum()),
    }


def icon(kind: str) -> Markup:
    """Return the symbol of a layer as in the figures."""
    drawn = {
        "tuned": diamond(8, 8),
        "default": square(8, 8),
        "front": element("circle", cx=8, cy=8, r=4, class_="mark-front"),
        "finalist": element("circle", cx=8, cy=8, r=4, class_="mark-finalist"),
        "start": element("path", d="M8 3l5 10h-10z", class_="mark-start"),
        "searched": element("circle", cx=8, cy=8, r=2.5, class_="mark-searched"),
        "infeasible": element("path", d="M5 5l6 6M11 5l-6 6", class_="mark-infeasible"),
        "intervals": element("path", d="M8 1v14M1 8h14", class_="mark-intervals"),
        "lost": element("path", d="M3 3l10 10M13 3l-10 10", class_="mark-lost"),
        "beyond": element("path", d="M3 4l10 4l-10 4z", class_="mark-front"),
    }
    return element("svg", drawn[kind], class_="icon", viewBox="0 0 16 16", width=16, height=16, aria_hidden="true")


def line(kind: str) -> Markup:
    """Return a short piece of line as in the figures of responses and loops."""
    drawn = element("path", d="M0 8h28", class_=f"line-{kind}")
    return element("svg", drawn, class_="icon", viewBox="0 0 28 16", width=28, height=16, aria_hidden="true")


def _switch(kind: str, label: Markup) -> Markup:
    box = element("input", type="checkbox", checked=kind not in ("searched", "infeasible"), data_layer=kind)
    return element("label", box, label, class_="switch")
