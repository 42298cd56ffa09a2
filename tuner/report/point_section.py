"""The picked point: numbers, gains, responses and loops. Scripts fill it for whichever point is picked."""

from tuner.documents.results import DEFAULT, Results
from tuner.report.controls import line
from tuner.report.figure_box import plot_box
from tuner.report.packed_responses import signals_of
from tuner.text.markup import Markup, element, join

RESPONSES_AID = (
    "Line: median over flights; band: 5 to 95 % of them; fine dashes: reference, for roll and pitch the mean of what the "
    "position loop asks for. Zooming one figure in time zooms all."
)
LOOPS_AID = (
    "The loop as it is flown, at hover in still air, at the amplitude of its nonlinear terms at which the sensitivity peaks "
    "highest; ∞: no crossing limits the margin."
)
BODE_AIDS = {
    "gain": "The loop follows and rejects where it is above 0 dB.",
    "phase": "Its distance from −180° where the gain is 0 dB is the phase margin.",
    "nyquist": "The further from −1 (cross) the better; outside the dotted circle Ms is below 2.",
}


def point_section(results: Results) -> Markup:
    """Return the section without its heading."""
    parts = [_choice(), element("p", id="point-state", class_="aid"), element("div", id="point-metrics", class_="wide")]
    parts += [
        element("p", "On held-out flights, by which points are chosen; the table at the top rests on fresh ones.", class_="aid"),
        element("h3", "Its gains"),
        element("div", id="point-gains", class_="wide"),
        *_behind(results),
        element("h3", "Its responses"),
        *_responses(results),
        element("h3", "Its loops"),
        *_loops(results),
    ]  # fmt: skip
    return join(parts)


def _choice() -> Markup:
    parts = (
        element("strong", id="point-name", class_="point-name"),
        element("label", "Point ", element("select", id="choose-point")),
        element("button", "← Previous", type="button", id="previous"),
        element("button", "Next →", type="button", id="next"),
        element("button", "Save gains.json", type="button", id="save-point"),
        element("button", "Copy gains", type="button", id="copy-point"),
    )
    return element("div", *parts, class_="controls")


def _behind(results: Results) -> list[Markup]:
    """Return the switch for the default behind what is drawn, and the key of all lines, once for responses and loops."""
    if not (results.fans or results.loops):
        return []
    keys = [("tuned", "picked point"), ("reference", "reference"), ("worst", "its worst flight")]
    shown = [element("span", line(kind), f" {text}", class_="key") for kind, text in keys]
    box = element("input", type="checkbox", id="behind", checked=True)
    switch = element("label", box, line("default"), " default behind it", class_="switch")
    return [element("div", switch, *shown, class_="controls lines-key")] if DEFAULT in results.front.roles else []


def _responses(results: Results) -> list[Markup]:
    signals = signals_of(results)
    if not signals:
        text = "This folder holds no recorded responses (responses.parquet is missing or empty)."
        return [element("p", text, class_="note")]
    boxes = [
        (is_rotor, plot_box(f"response-{k}", title, "", "plot"))
        for k, (title, is_rotor) in enumerate(signals)
    ]  # fmt: skip
    scenarios = [element("option", name, value=k) for k, name in enumerate(results.scenarios)]
    choice = element("label", "Scenario ", element("select", *scenarios, id="choose-scenario"))
    return [
        element("p", RESPONSES_AID, class_="aid"),
        element("div", *([choice] if len(scenarios) > 1 else []), element("span", id="responses-of", role="status"),
                class_="controls"),
        *[element("div", *[box for rotor, box in boxes if rotor == wanted], class_=f"grid {form}")
          for wanted, form in ((False, "axis-grid"), (True, "rotor-grid"))],
    ]  # fmt: skip


def _loops(results: Results) -> list[Markup]:
    if not results.loops:
        text = "This folder holds no margins of its finalists (margins.parquet is missing); `tuner margins` works them out."
        return [element("p", text.replace("`", ""), class_="note")]
    channels = dict.fromkeys(loop.channel for loop in results.loops)
    options = [element("option", name, value=k) for k, name in enumerate(channels)]
    titles = {"gain": "Bode: gain", "phase": "Bode: phase", "nyquist": "Nyquist"}
    return [
        element("p", LOOPS_AID, class_="aid"),
        element("div", id="margins", class_="wide"),
        element("div", element("label", "Curves of loop ", element("select", *options, id="choose-channel")), class_="controls"),
        element("div", *[plot_box(f"loop-{key}", title, BODE_AIDS[key]) for key, title in titles.items()],
                class_="grid axis-grid"),
    ]  # fmt: skip
