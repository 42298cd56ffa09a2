"""The trade-off: controls, linked views and the table of finalists. Scripts draw them from the data of the page."""

from collections.abc import Mapping, Sequence
from itertools import count

from tuner.documents.summary import TableRow
from tuner.documents.tuning import TuningFolder
from tuner.report.charts.front import front_panels
from tuner.report.charts.sketch import sketch
from tuner.report.labels import named
from tuner.report.page import aid
from tuner.text.markup import Markup, element, join
from tuner.text.units import bracketed, plain

NOTHING = Markup()
WALK = "Arrow keys step through the finalists, P pins the picked one, Escape clears the selection."
AID = (
    "A selection in one view, by a drawn box or a slider, applies to all views, the table and the charts below. Click a mark, or "
    "use the arrow keys, to pick a point. Shift-click or P pins it: up to four points are laid over each other below."
)


def explorer_section(results: TuningFolder, limits: Sequence[TableRow]) -> Markup:
    """Return the section without its heading.

    Args:
        results: Folder of the run.
        limits: Limited quantities that differ among finalists.
    """
    objectives = len(results.objectives)
    views = []
    if objectives == 3:
        text = "Each stem ends on the floor below its mark. Drag to turn."
        views.append(view_box("space", "All three objectives", text, "Arrow keys turn the view."))
    if objectives > 2:
        text = "Every pair of objectives. Draw a box to select, double-click to clear."
        views.append(view_box("matrix", "Scatter matrix", text, WALK))
    finalists = element("div", class_="wide tall", id="finalists", tabindex="0", role="region", aria_label="Finalists")
    table = element(
        "div",
        element("h3", "Finalists selected"),
        aid("Held-out values with 95 % intervals. Click a heading to sort."),
        finalists,
    )
    lower = [_parallel(len(limits))] if objectives + len(results.variables) + len(limits) > 1 else []
    return join(
        (
            aid(AID),
            _levels("levels", "Objectives: largest value accepted"),
            _levels("limit-levels", "Limited quantities: value required") if limits else "",
            _selection(),
            element("div", *views, class_="grid explorer pair-views") if views else "",
            *lower,
            _slices(results, limits),
            table,
        )
    )


def view_box(name: str, title: str, text: str, keys: str, still: Markup = NOTHING) -> Markup:
    """Return the frame of a view that keys reach; keys: what they do; still: what is seen until the view is drawn."""
    drawn = element(
        "div",
        still,
        id=name,
        class_=f"view {name}",
        tabindex="0",
        role="application",
        aria_roledescription="chart",
        aria_label=f"{title}. {text} {keys}",
    )
    caption = element("figcaption", title, element("small", text, class_="reading"))
    return element("figure", caption, element("div", drawn, class_="scroller"), class_=f"{name}-figure")


def plane(results: TuningFolder) -> Markup:
    """Return the frame of the trade-off in two dimensions, with a still drawing of the first two objectives."""
    text = "Down and to the left is better; bars: 95 % intervals. Click to pick, draw a box to select."
    still = sketch(front_panels(results)[0]) if len(results.objectives) > 1 else NOTHING
    return view_box("plane", "Trade-off", text, WALK, still)


def axis_choices(results: TuningFolder, limits: Sequence[TableRow]) -> Markup:
    """Return the choice of both axes of the plane."""
    groups = _axis_groups(results, limits)
    second = min(1, len(results.objectives) + len(results.variables) + len(limits) - 1)
    return element(
        "div", _choice("x", "Horizontal", groups, 0), _choice("y", "Vertical", groups, second), class_="controls"
    )


def _axis_groups(results: TuningFolder, limits: Sequence[TableRow]) -> dict[str, list[tuple[int, str]]]:
    """Return the dimensions that an axis may have, by group: number and name."""
    names = {
        "Objectives": [bracketed(named(results, entry, short=True), entry.unit) for entry in results.objectives],
        "Gains": [bracketed(v.name, plain("" if v.unit == "1" else v.unit)) for v in results.variables],
        "Limits": [bracketed(named(results, entry, short=True), entry.unit) for entry in limits],
    }
    numbers = count()
    return {title: [(next(numbers), name) for name in group] for title, group in names.items()}


def _choice(key: str, words: str, groups: Mapping[str, Sequence[tuple[int, str]]], selected: int) -> Markup:
    """Return the choice of an axis; selected: number of the dimension that it begins with."""
    parts = [
        element(
            "optgroup",
            *[element("option", name, value=number, selected=number == selected) for number, name in group],
            label=title,
        )
        for title, group in groups.items()
        if group
    ]
    return element("label", words, " ", element("select", *parts, id=f"axis-{key}"))


def _slices(results: TuningFolder, limits: Sequence[TableRow]) -> Markup:
    """Return the frame of the slices with the choice of both axes."""
    text = "Candidates, whose other gains differ too; for limits on flights finalists alone. Shaded: beyond a limit or the range."
    groups = _axis_groups(results, limits)
    gains = {"Gains": groups.pop("Gains")}
    choices = (
        _choice("slice", "Gain", gains, len(results.objectives)),
        _choice("against", "Against", groups, 0),
    )
    return element(
        "div",
        view_box("slices", "A gain and an objective", text, WALK),
        element("div", *choices, class_="controls also"),
    )


def _parallel(limits: int) -> Markup:
    text = "One line per point, lower is better, off-scale values clipped. Drag along an axis to select; double-click to clear."
    box = view_box("parallel", "Parallel coordinates", text, WALK)
    switches = [
        element("label", element("input", type="checkbox", id=f"with-{key}"), f" {key}", class_="switch")
        for key in ("gains", *(["limits"] if limits else []))
    ]
    return element("div", box, element("div", "Show also: ", *switches, class_="controls also"))


def _levels(key: str, title: str) -> Markup:
    return element("fieldset", element("legend", title), element("div", id=key, class_="level-rows"), class_="levels")


def _selection() -> Markup:
    parts = (
        element("span", id="count", role="status"),
        element("span", id="chips"),
        element("button", "Select all", type="button", id="clear", hidden=True),
    )
    return element("div", *parts, class_="controls selection", id="selection")
