"""The picked point: gains, responses and loops. Scripts fill it for whichever point is picked, the recommended one first."""

from collections.abc import Sequence

from tuner.documents.states import tightest_margins
from tuner.documents.summary import RequiredRow
from tuner.documents.tuning import DEFAULT, TuningFolder
from tuner.report.charts.chart import Panel
from tuner.report.charts.look import DEFAULT as DEFAULT_LOOK
from tuner.report.charts.look import REFERENCE, TUNED, sample, worst_look
from tuner.report.charts.web import grid
from tuner.report.gains_section import gains_table, study_lines
from tuner.report.labels import plain_margin
from tuner.report.page import aid, collapsible, wide
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import significant
from tuner.text.sentences import bound_text
from tuner.text.units import plain

GAINS_AID = (
    "Gains in the units of the study file, angles in rad. Open square: default; filled diamond: the point. gains.json holds them "
    "with units, structure and origin, and tuner fly takes it."
)
NEAREST_AID = (
    "This point violates limits: do not fly it; it is in infeasible.json, which tuner export refuses. Open square: "
    "default; filled diamond: nearest. Gains in the units of the study file, angles in rad."
)
PLANT_GAINS_AID = (
    "Gains in the units of the study file, angles in rad. Open square: default; filled diamond: the point. gains.json holds them "
    "with units and origin, and tuner export takes it."
)
VARIABLES_AID = (
    "Values of the variables in their own units. Open square: default; filled diamond: the point. gains.json holds them with "
    "units and origin."
)
RESPONSES_AID = (
    "Line: median over flights; band: 5 to 95 %; dotted: reference, for {inner} the mean setpoint of the {outer}; dashed: "
    "limits, where a signal comes near one. Time axes zoom together."
)
LOOPS_AID = (
    "Open loop {where}, at the amplitude of its nonlinear terms with the largest peak sensitivity; ∞: no crossing limits the "
    "margin. The table holds the worst over all amplitudes."
)
METRICS_AID = "Held-out flights, used for selection; the table at the top uses independent confirmation flights."


def point_section(results: TuningFolder, responses: Sequence[Panel], loops: Sequence[Panel]) -> Markup:
    """Return the section without its heading."""
    metrics = collapsible("Held-out values", aid(METRICS_AID), wide(Markup(), id="point-metrics"), id="point-numbers")
    return join(
        (
            _choice(),
            element("p", id="point-why"),
            element("p", id="point-state", class_="aid"),
            aid(_gains_aid(results)),
            wide(gains_table(results), id="point-gains"),
            element("div", metrics, *_copies(results), class_="foldings"),
            *_behind(results),
            *_plant(results, responses, loops),
        )
    )


def _gains_aid(results: TuningFolder) -> str:
    if not results.feasible:
        return NEAREST_AID
    if results.is_external:
        return VARIABLES_AID
    return PLANT_GAINS_AID if results.resolved.plant else GAINS_AID


def _plant(results: TuningFolder, responses: Sequence[Panel], loops: Sequence[Panel]) -> list[Markup]:
    """Return responses and loops; nothing where the plant is that of another program."""
    if results.is_external:
        return []
    return [
        element("h3", "Responses"),
        *_responses(results, responses),
        element("h3", "Loops"),
        *_loops(results, loops),
    ]


def _choice() -> Markup:
    parts = (
        element("strong", id="point-name", class_="point-name"),
        element("label", "Point ", element("select", id="choose-point")),
        element("button", "← Previous", type="button", id="previous"),
        element("button", "Next →", type="button", id="next"),
        element("button", "Pin", type="button", id="pin", aria_pressed="false"),
        element("button", "Save gains.json", type="button", id="save-point"),
        element("button", "Copy gains", type="button", id="copy-point"),
    )
    return element("div", *parts, class_="controls")


def _copies(results: TuningFolder) -> list[Markup]:
    texts = (
        (f"The {results.shown_name} for the study file", "copy-study", study_lines(results)),
        (f"{results.document.gains_file} of the {results.shown_name}", "copy-all", results.gains_text),
    )
    return [
        collapsible(
            name, element("button", "Copy", type="button", data_copy=key), element("pre", text, id=key, tabindex="0")
        )
        for name, key, text in texts
    ]


def _behind(results: TuningFolder) -> list[Markup]:
    """Return the switch for the default behind what is drawn, and the key of all lines, once for responses and loops."""
    if not (results.fans or results.loops) or "default" not in results.held_out_front.roles:
        return []
    worst = "flight or steady state" if results.worst_loops else "flight"
    keys = [
        (TUNED, "selected point"),
        (worst_look(TUNED), f"its worst {worst}"),
        (worst_look(DEFAULT_LOOK), f"worst {worst} of the default"),
        (REFERENCE, "reference"),
    ]
    shown = [element("span", sample(look, marked=False), f" {text}", class_="key") for look, text in keys]
    box = element("input", type="checkbox", id="behind", checked=True)
    switch = element("label", box, sample(DEFAULT_LOOK, marked=False), " default", class_="switch")
    pins = element("div", id="pins", class_="controls", role="group", aria_label="Pinned points")
    return [element("div", switch, *shown, class_="controls lines-key"), pins]


def _responses(results: TuningFolder, panels: Sequence[Panel]) -> list[Markup]:
    if not panels:
        text = "This folder holds no recorded responses (responses.npz is missing or empty)."
        return [element("p", text, class_="note")]
    scenarios = [element("option", name, value=name) for name in results.scenarios]
    choice = element("label", "Scenario ", element("select", *scenarios, id="choose-scenario"))
    status = element("span", id="responses-of", role="status")
    inner, outer = ("roll and pitch", "position loop") if results.has_rotors else ("an inner loop", "outer one")
    rotors = [panel for panel in panels if "rotor" in panel.form]
    spectra = [panel for panel in panels if panel.key == "spectrum"]
    return [
        aid(RESPONSES_AID.format(inner=inner, outer=outer)),
        element("div", *([choice] if len(scenarios) > 1 else []), status, class_="controls"),
        grid([panel for panel in panels if panel not in (*rotors, *spectra)], "axis-grid"),
        grid(rotors, "rotor-grid"),
        *([grid(spectra, "axis-grid")] if spectra else []),
    ]


def worst_state_text(results: TuningFolder) -> str:
    """Return the worst steady states of tuned gains and default in words; "" if hover alone was looked at."""
    worst = tightest_margins(results.requirements)
    parts = [_worst_text(results, role, row) for role, row in reversed(worst.items())]
    return f" Worst steady state, drawn thin unless it is hover: {'; '.join(parts)}." if parts else ""


def _worst_text(results: TuningFolder, role: str, row: RequiredRow) -> str:
    of, value, state = (
        (f"default {results.gains_noun}", row.default.value, row.default_state)
        if role == DEFAULT
        else (results.shown_name, row.tuned.value, row.tuned_state)
    )
    number = "∞" if value is None else significant(value, 3)
    limit = f"{bound_text(row.limit, row.sense)} {plain(row.unit)}".rstrip()
    return f"{of} in {state} ({plain_margin(row.label)} {number}, {limit})"


def _loops(results: TuningFolder, panels: Sequence[Panel]) -> list[Markup]:
    if not panels:
        text = (
            "This folder holds no margins of its finalists (margins.npz is missing); compute them with tuner margins."
        )
        return [element("p", text, class_="note")]
    options = [element("option", name, value=name) for name in dict.fromkeys(loop.channel for loop in results.loops)]
    choice = element("label", "Curves of loop ", element("select", *options, id="choose-channel"))
    where = "at hover in still air" if results.has_rotors else "at the equilibrium of the plant"
    return [
        aid(f"{LOOPS_AID.format(where=where)}{worst_state_text(results)}"),
        element("div", id="margins", class_="wide"),
        element("div", choice, class_="controls"),
        grid(panels, "axis-grid"),
    ]
