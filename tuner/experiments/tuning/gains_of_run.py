"""gains.json of a run: the recommended point with its origin, its held-out values and its margins."""

from math import isfinite
from typing import Any

from objectives.margins.quantities import QUANTITIES, RECORDED
from objectives.margins.results import Margins
from plant.errors import InputError
from plant.texts import PlainTable
from tuner.documents.summary import ComparedRow, RequiredRow, Summary
from tuner.experiments.tuning.outcome import FlightOutcome, Outcome
from tuner.gains.quantities import code_or_note, quantity
from tuner.gains.sections import DEMAND, DESCRIBING, LINEARISED, PLANT_INPUT

# Of `objectives.risk.bootstrap`, with the level that `tuner.analysis.held_out` asks for.
LEVEL, METHOD = 0.95, "bootstrap over flights, studentised where the risk has a standard error"
EXACT = "Clopper-Pearson; of the difference of the flights that end differently"
# Significant digits of a margin; further ones depend on the linear algebra of the machine.
DIGITS = 6


def gains_document(outcome: FlightOutcome, summary: Summary) -> PlainTable:
    """Return the content of gains.json for the point that a summary shows.

    If nothing is feasible it says so, and `tuner export` refuses it.
    """
    parts = {
        "study": outcome.study.origin(summary.shown) | ({} if outcome.feasible else {"feasible": False}),
        "objectives": objective_rows(outcome),
        "margins": margin_rows(outcome),
    }
    return outcome.study.gains_document(
        outcome.gains(outcome.tuned), {key: part for key, part in parts.items() if part}
    )


def objective_rows(outcome: Outcome) -> list[PlainTable]:
    """Return the results of the confirmation flights; sampled values come first, with their intervals."""
    sampled = [objective_row(row) for row in outcome.table]
    flights = [outcome.confirmation.samples(i, row.scenario).shape[-1] for i, row in enumerate(outcome.table)]
    required = [objective_row(row) for row in outcome.required_rows]
    methods = [METHOD if row.tuned_count is None else EXACT for row in outcome.table]
    rows = zip(sampled, flights, methods, strict=True)
    return [*[{**row, "interval": interval(n, method)} for row, n, method in rows], *required]


def objective_row(row: ComparedRow | RequiredRow) -> PlainTable:
    """Return a row of the Default / Tuned table for gains.json."""
    keys = {"label", "unit", "kind", "limit", "default", "tuned", "difference", "verdict"}
    state = {"state": row.tuned_state} if isinstance(row, RequiredRow) and row.tuned_state else {}
    return {**row.model_dump(include=keys), "unit": code_or_note(row.unit), **state}


def interval(flights: int, method: str = METHOD) -> PlainTable:
    """Return the method of the intervals over so many flights."""
    return {"level": LEVEL, "n": flights, "method": method}


def margin_rows(outcome: FlightOutcome) -> list[PlainTable]:
    """Return the margins of the recommended point, loop by loop; none where no steady flight is found."""
    try:
        model = outcome.study.margin_model()
    except InputError:
        return []
    margins = model.evaluate(outcome.finalist_rows[[outcome.tuned]])
    looped = {channel for block in model.blocks for channel in block}
    return [margin_row(model, margins, channel) for channel in margins.channels if channel in looped]


def margin_row(model: Any, margins: Margins, channel: str) -> PlainTable:
    """Return the margins of one loop; what no crossing limits is left out, and everything where the loop is not stable."""
    i = margins.channels.index(channel)
    stable, case = bool(margins.stable[0, i]), int(margins.sensitivity.case[0, i])
    values = {name: float(QUANTITIES[name].values(margins)[0, i]) for name in RECORDED}
    swept: PlainTable = {"amplitude": model.cases[case].label} if case >= 0 else {}
    return {
        "loop": channel,
        "break_at": DEMAND if channel in ("x", "y") else PLANT_INPUT,
        "method": DESCRIBING if swept else LINEARISED,
        **swept,
        "stable": stable,
        **{
            name: quantity(float(f"{value:.{DIGITS}g}"), QUANTITIES[name].unit)
            for name, value in values.items()
            if stable and isfinite(value)
        },
    }
