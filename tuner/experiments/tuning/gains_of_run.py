"""gains.json of a run: the recommended point with its origin, its held-out values and its margins."""

from functools import singledispatch
from math import isfinite
from typing import Any

from objectives.margins.quantities import QUANTITIES, RECORDED
from objectives.margins.results import Margins
from plant.errors import InputError
from tuner.documents.summary import ComparedRow, RequiredRow, Summary
from tuner.experiments.tuning.outcome import FlightOutcome, Outcome
from tuner.experiments.tuning.tables import margin_model
from tuner.gains import to_document
from tuner.gains.plant_document import plant_gains_document
from tuner.gains.quantities import code_or_note, quantity
from tuner.gains.sections import DEMAND, DESCRIBING, LINEARISED, PLANT_INPUT
from tuner.study.plant_study import PlantStudy
from tuner.study.processor_cost.cost import gains_rows, tabled
from tuner.study.study import Study, TuningStudy

Row = dict[str, Any]

# Of `objectives.risk.bootstrap`, with the level that `tuner.analysis.held_out` asks for.
LEVEL, METHOD = 0.95, "bootstrap over flights, studentised where the risk has a standard error"
EXACT = "Clopper-Pearson; of the difference of the flights that end differently"
# Significant digits of a margin; further ones depend on the linear algebra of the machine.
DIGITS = 6


def gains_document(outcome: FlightOutcome, summary: Summary) -> Row:
    """Return the content of gains.json for the point that a summary shows beside the default.

    Where nothing is feasible it says so, and `tuner export` refuses it.
    """
    return document_of(outcome.study, outcome, summary)


@singledispatch
def document_of(study: TuningStudy, outcome: FlightOutcome, summary: Summary) -> Row:
    """Return the content of gains.json of a study."""
    raise TypeError(f"no gains.json of {study.kind}, {outcome.tuned}, {summary.study}")


@document_of.register
def _(study: PlantStudy, outcome: FlightOutcome, summary: Summary) -> Row:
    origin = study.origin(summary.shown) | ({} if outcome.feasible else {"feasible": False})
    parts = {"study": origin, "objectives": objective_rows(outcome), "margins": margin_rows(outcome)}
    return plant_gains_document(study.system, outcome.gains(outcome.tuned), study.code_digest) | {
        key: part for key, part in parts.items() if part
    }


@document_of.register
def _(study: Study, outcome: FlightOutcome, summary: Summary) -> Row:
    controller = study.controller(outcome.gains(outcome.tuned))
    provenance = {
        "study": study.origin(summary.shown) | ({} if outcome.feasible else {"feasible": False}),
        "objectives": objective_rows(outcome),
        "margins": margin_rows(outcome),
        "cost": gains_rows(tabled(controller.cascade.position.name, controller.cascade.attitude.name)),
    }  # fmt: skip
    ranges = {
        address: (variable.low, variable.high) for variable in study.space.variables for address in variable.addresses
    }
    return to_document(controller, {key: part for key, part in provenance.items() if part}, ranges)


def objective_rows(outcome: Outcome) -> list[Row]:
    """Return what the flights that decided nothing say; what was sampled comes first, and says how sure it is."""
    sampled = [objective_row(row) for row in outcome.table]
    flights = [outcome.confirmation.samples(i, row.scenario).shape[-1] for i, row in enumerate(outcome.table)]
    known = [objective_row(row) for row in outcome.known]
    methods = [METHOD if row.tuned_count is None else EXACT for row in outcome.table]
    rows = zip(sampled, flights, methods, strict=True)
    return [*[{**row, "interval": interval(n, method)} for row, n, method in rows], *known]


def objective_row(row: ComparedRow | RequiredRow) -> Row:
    """Return one line of the Default / Tuned table as gains.json holds it."""
    keys = {"label", "unit", "kind", "limit", "default", "tuned", "difference", "verdict"}
    state = {"state": row.tuned_state} if isinstance(row, RequiredRow) and row.tuned_state else {}
    return {**row.model_dump(include=keys), "unit": code_or_note(row.unit), **state}


def interval(flights: int, method: str = METHOD) -> Row:
    """Return how the intervals over so many flights were made."""
    return {"level": LEVEL, "n": flights, "method": method}


def margin_rows(outcome: FlightOutcome) -> list[Row]:
    """Return the margins of the recommended point, loop by loop; none where no steady flight is found."""
    try:
        model = margin_model(outcome)
    except InputError:
        return []
    margins = model.evaluate(outcome.finalist_rows[[outcome.tuned]])
    looped = {channel for block in model.blocks for channel in block}
    return [margin_row(model, margins, channel) for channel in margins.channels if channel in looped]


def margin_row(model: Any, margins: Margins, channel: str) -> Row:
    """Return the margins of one loop; what no crossing limits is left out, and everything where the loop is not stable."""
    i = margins.channels.index(channel)
    stable, case = bool(margins.stable[0, i]), int(margins.sensitivity.case[0, i])
    values = {name: float(QUANTITIES[name].values(margins)[0, i]) for name in RECORDED}
    swept: Row = {"amplitude": model.cases[case].label} if case >= 0 else {}
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
