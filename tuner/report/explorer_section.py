"""The trade-off: controls, linked views and the table of finalists. Scripts draw them from the data of the page."""

from tuner.documents.results import Results
from tuner.report.controls import layer_switches
from tuner.report.figure_box import canvas_box
from tuner.text.markup import Markup, element, join
from tuner.text.units import bracketed, plain

WALK = "Arrow keys walk along the finalists, Escape lets go of the selection."
AID = (
    "Every view shows the same points: what is selected in one, by drawing a box or with the sliders, is selected in all, in "
    "the table and in the figures below. Click a mark, or walk with the arrow keys, to pick a point."
)


def explorer_section(results: Results) -> Markup:
    """Return the section without its heading."""
    count = len(results.objectives)
    views = [_plane()]
    if count == 3:
        aid = "Each stem ends on the floor below its mark. Drag to turn."
        views.append(canvas_box("space", "All three objectives", aid, "Arrow keys turn the view."))
    lower = [_parallel()] if count + len(results.variables) > 1 else []
    if count > 2:
        aid = "Every pair of objectives, smaller values down and to the left. Draw a box to select, double-click to let go."
        lower.append(canvas_box("matrix", "Scatter matrix", aid, WALK))
    form = "explorer pair-views" if count == 3 else "explorer"
    return join(
        (
            element("p", AID, class_="aid"),
            layer_switches(results),
            _levels(),
            _selection(),
            _axis_choices(results),
            element("div", *views, class_=f"grid {form}"),
            *[element("div", view, class_="grid explorer") for view in lower],
            element("h3", "Finalists selected"),
            element("p", "Held-out values with 95 % intervals. Headings sort.", class_="aid"),
            element("div", class_="wide tall", id="finalists", tabindex="0", role="region", aria_label="Finalists"),
        )
    )


def _plane() -> Markup:
    aid = "Down and to the left is better; bars are 95 % intervals. Draw a box to select, double-click to let go."
    return canvas_box("plane", "Trade-off", aid, WALK)


def _axis_choices(results: Results) -> Markup:
    """Return the choice of both axes of the plane, among objectives and gains."""
    groups = [
        ("Objectives", [bracketed(entry.label, entry.unit) for entry in results.objectives]),
        ("Gains", [bracketed(v.name, plain("" if v.unit == "1" else v.unit)) for v in results.variables]),
    ]
    labels, second = [], min(1, len(results.objectives) + len(results.variables) - 1)
    for name, words, at in (("x", "Across", 0), ("y", "Up", second)):
        before, options = 0, []
        for title, names in groups:
            entries = [
                element("option", text, value=before + k, selected=before + k == at) for k, text in enumerate(names)
            ]
            before += len(names)
            options.append(element("optgroup", *entries, label=title))
        labels.append(element("label", words, " ", element("select", *options, id=f"axis-{name}")))
    return element("div", *labels, class_="controls")


def _parallel() -> Markup:
    aid = "One line a point, low values down, beyond an axis at its end. Draw along an axis to select, double-click to let go."
    box = canvas_box("parallel", "Parallel coordinates", aid, WALK)
    gains = element("label", element("input", type="checkbox", id="with-gains"), " gains as well", class_="switch")
    return element("div", element("div", gains, class_="controls"), box)


def _levels() -> Markup:
    legend = element("legend", "Aspiration levels: how much of each objective is acceptable")
    return element("fieldset", legend, element("div", id="levels"), class_="levels")


def _selection() -> Markup:
    parts = (
        element("span", id="count", role="status"),
        element("span", id="chips"),
        element("button", "Select all", type="button", id="clear", hidden=True),
    )
    return element("div", *parts, class_="controls selection", id="selection")
