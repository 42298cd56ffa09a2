"""Contenders as they look in every chart and table, and what a reader can switch: who is drawn, and what responses show."""

from tuner.documents.comparison import ComparedFolder
from tuner.report.charts.look import looks_of, sample
from tuner.text.markup import Markup, element, join

# What the responses can show of a contender, and whether they do at first.
LAYERS = {"flight": ("flight 0", True), "band": ("5–95 % of flights", True), "median": ("median of flights", False)}


def contender_switches(compared: ComparedFolder) -> Markup:
    """Return a checkbox with line and symbol for each contender: the legend of all figures, which stays in sight."""
    boxes = [
        _switch(compared.layer(entry.name), True, sample(looks_of(compared)[entry.name]), entry.name)
        for entry in compared.contenders
    ]
    legend = element("legend", "Contenders shown in the figures", class_="hidden")
    return element("fieldset", legend, *boxes, class_="controls contenders-bar", id="contenders")


def interval_switch() -> Markup:
    """Return the checkbox for the intervals of the fronts."""
    return element("div", _switch("intervals", True, "95 % intervals"), class_="controls", id="layers")


def response_choices(compared: ComparedFolder) -> Markup:
    """Return the choices of scenario and airframe, and of what is drawn of each contender."""
    parts = [
        _choice("Scenario ", compared.scenarios, "choose-scenario"),
        _choice("Airframe ", compared.flown, "choose-airframe"),
    ]
    for layer, (text, shown) in LAYERS.items():
        if compared.traces if layer == "flight" else compared.fans:
            parts.append(_switch(layer, shown, text))
    return element("div", join(parts), class_="controls", id="choices")


def _choice(text: str, names: list[str], key: str) -> Markup:
    """Return a choice among names, nothing where there is none to make."""
    if len(names) < 2:
        return Markup()
    return element("label", text, element("select", *[element("option", name, value=name) for name in names], id=key))


def _switch(layer: str, shown: bool, *text: str) -> Markup:
    box = element("input", type="checkbox", checked=shown, data_layer=layer)
    return element("label", box, *text, class_="switch")
