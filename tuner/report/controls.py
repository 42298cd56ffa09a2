"""What a reader can switch: layers of the front, and which responses are shown. Native controls, so keys reach them."""

from tuner.report.chart import Charts
from tuner.report.drawings import diamond, square
from tuner.report.markup import Markup, element, join
from tuner.report.numbers import count
from tuner.report.response_charts import role_of
from tuner.report.results import DEFAULT, Results

LAYERS = {
    "tuned": "tuned",
    "default": "default",
    "front": "front, held-out",
    "finalist": "off the front when held out",
    "searched": "other candidates, search values",
    "infeasible": "constraint broken, search values",
}
BEHIND = "behind"


def layer_switches(charts: Charts) -> Markup:
    """Return a checkbox with symbol for each layer that some figure of the front has, and one for the intervals."""
    shown = {
        trace["meta"]["layer"]: len(charts.shared[f"hover-{trace['meta']['layer']}"])
        for chart in charts.charts.values()
        for trace in chart["traces"]
        if "layer" in trace.get("meta", {})
    }
    boxes = [
        _switch(kind, join((icon(kind), f" {label}", f" ({count(shown[kind])})" if shown[kind] > 1 else "")))
        for kind, label in LAYERS.items()
        if kind in shown
    ]
    boxes.append(_switch("intervals", join((icon("intervals"), " 95 % intervals"))))
    return element("fieldset", element("legend", "Show", class_="hidden"), *boxes, class_="controls", id="layers")


def response_choices(results: Results) -> Markup:
    """Return the choice of point and scenario, and whether the default is drawn behind the point."""
    order = sorted(results.flown_points, key=lambda name: results.front.role(name) != "tuned")
    points = [element("option", _point_name(results, name), value=name) for name in order]
    scenarios = [element("option", name, value=name) for name in results.scenarios]
    parts = [element("label", "Point ", element("select", *points, id="choose-point"))]
    if len(scenarios) > 1:
        parts.append(element("label", "Scenario ", element("select", *scenarios, id="choose-scenario")))
    if DEFAULT in order and len(order) > 1:
        box = element("input", type="checkbox", id=BEHIND, checked=True)
        parts.append(element("label", box, line("default"), " default behind it", class_="switch"))
    keys = [("chosen", "tuned", "chosen point: median and 5–95 % band"), ("reference", "reference", "reference")]
    shown = [element("span", line(kind), f" {text}", class_=f"key key-{name}") for name, kind, text in keys]
    return element("div", *parts, *shown, class_="controls", id="choices")


def icon(kind: str) -> Markup:
    """Return the symbol of a layer as in the figures."""
    drawn = {
        "tuned": diamond(8, 8),
        "default": square(8, 8),
        "front": element("circle", cx=8, cy=8, r=4, class_="mark-front"),
        "finalist": element("circle", cx=8, cy=8, r=4, class_="mark-finalist"),
        "searched": element("circle", cx=8, cy=8, r=2.5, class_="mark-searched"),
        "infeasible": element("path", d="M5 5l6 6M11 5l-6 6", class_="mark-infeasible"),
        "intervals": element("path", d="M8 1v14M1 8h14", class_="mark-intervals"),
    }
    return element("svg", drawn[kind], class_="icon", viewBox="0 0 16 16", width=16, height=16, aria_hidden="true")


def line(kind: str) -> Markup:
    """Return a short piece of line as in the figures of the responses."""
    drawn = element("path", d="M0 8h28", class_=f"line-{kind}")
    return element("svg", drawn, class_="icon", viewBox="0 0 28 16", width=28, height=16, aria_hidden="true")


def _switch(kind: str, label: Markup) -> Markup:
    box = element("input", type="checkbox", checked=True, data_layer=kind)
    return element("label", box, label, class_="switch")


def _point_name(results: Results, name: str) -> str:
    role = role_of(results, name)
    if role == DEFAULT:
        return "default"
    if role == "tuned":
        return f"{name}, tuned"
    front = results.front
    if name not in front.points:
        return name
    smallest = front.held_out[front.non_dominated].min(axis=0, initial=float("inf"))
    held_out = front.held_out[front.points.index(name)]
    best = [entry.label for entry, least in zip(results.objectives, held_out <= smallest, strict=True) if least]
    return f"{name}, smallest {' and '.join(best)}" if best else name
