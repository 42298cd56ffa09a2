"""summary.json and gains.json of a run: what was found, in numbers that a person or a program can read."""

from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from objectives.problem import Objective
from objectives.risk import RISKS
from objectives.scales import in_file, units_of
from plant.air.air import summary as air_summary
from plant.gains import gain_addresses
from tuner.analysis.held_out import Comparison, Estimate, KnownComparison
from tuner.experiments.tuning.conflicts import Conflict, Cost, Limit, Relaxation, limits_of
from tuner.experiments.tuning.ending import ending_of
from tuner.experiments.tuning.gains_of_run import gains_document
from tuner.search.loop import point_name
from tuner.study.bounds import ENDS, natural_end
from tuner.study.trim import trim_entry

if TYPE_CHECKING:
    from tuner.experiments.tuning.outcome import Outcome


def summary_document(outcome: "Outcome") -> dict[str, Any]:
    """Return the content of summary.json; under "gains_document" that of gains.json."""
    from tuner.experiments.tuning.conclusion import default_candidate, remarks

    study, finalists = outcome.study, outcome.finalists
    shown, feasible = outcome.names[outcome.tuned], outcome.feasible
    floors = {entry.objective.label: entry.floor for entry in study.constraints}
    compared = [comparison_row(row) for row in outcome.table]
    compared = [
        {**row, "automatic": floors.get(row["label"], "") if row["kind"] == "constraint" else ""} for row in compared
    ]
    table = compared + [known_row(row) for row in outcome.known]
    last = outcome.generations[-1]
    limits = limits_of(study.constraints, study.requirements)
    return {
        "feasible": feasible,
        "ending": ending_of(outcome),
        "title": study.title,
        "study": study.path.name,
        "tuned": shown if feasible else None,
        "nearest": None if feasible else shown,
        "pick": {"rule": study.pick, "why": outcome.why},
        "flights": outcome.flights,
        "screened": {"candidates": last.screened, "flights": last.flights_saved},
        "raced": {"candidates": last.raced, "flights": last.flights_raced},
        "wall_seconds": outcome.seconds,
        "search_seconds": {
            "screening": sum(entry.evaluation.screening_seconds for entry in outcome.generations),
            "flights": sum(entry.evaluation.flight_seconds for entry in outcome.generations),
        },
        "held_out": sum(entry.held_out for entry in study.scenarios),
        "front_size": int(finalists.non_dominated.sum()),
        "hypervolume": last.hypervolume,
        "picked_on": pick_row(outcome),
        "conflict": conflict_row(outcome.conflict, limits, default_candidate(outcome.archive, study)),
        "obstacles": [entry.row() for entry in outcome.obstacles],
        "costs": [cost_row(cost, limits, study.objectives) for cost in outcome.costs],
        "remarks": remarks(outcome),
        "warnings": outcome.warnings,
        "variables": variables(outcome),
        "table": table,
        "air": [
            {"scenario": entry.spec.name, **air_summary(entry.spec.air), **trim_entry(entry.spec, study.system)}
            for entry in study.scenarios
        ],
        "gains_document": gains_document(outcome, shown, table),
    }


def pick_row(outcome: "Outcome") -> dict[str, Any]:
    """Return what the recommended point was picked by: its held-out values and how sure its place on the front is."""
    finalists, row = outcome.finalists, outcome.tuned
    return {
        "probability": float(finalists.probability[row]),
        "lost_in_search": lost_in_search(outcome),
        "objectives": [
            {
                "label": objective.label,
                "unit": objective.metric.unit,
                "search": float(finalists.search[row, i]),
                "held_out": _estimate(finalists.evaluation.values, finalists.low, finalists.high, row, i),
                "gap": _estimate(finalists.gap, finalists.gap_low, finalists.gap_high, row, i),
            }
            for i, objective in enumerate(outcome.study.objectives)
        ],
    }


def lost_in_search(outcome: "Outcome") -> float | None:
    """Return the share of its flights in the search that the recommended point lost, None where it was not flown there."""
    failures = np.concatenate([entry.evaluation.failures for entry in outcome.generations])
    candidate = outcome.candidates[outcome.tuned - 1]
    return float(failures[candidate]) if outcome.archive.flown[candidate] else None


def _estimate(value: np.ndarray, low: np.ndarray, high: np.ndarray, row: int, column: int) -> dict[str, float]:
    return Estimate(*[float(part[row, column]) for part in (value, low, high)]).as_dict()


def conflict_row(conflict: Conflict | None, limits: list[Limit], default: int | None) -> dict[str, Any] | None:
    """Return which limits nobody kept together and what would help, None where something was feasible.

    default: the candidate that is the default, None where the search did not try it.
    """
    if conflict is None:
        return None
    return {
        "sets": [[limits[i].label for i in some] for some in conflict.sets],
        "single": [relaxation_row(entry, limits, default) for entry in conflict.single],
        "common": None if conflict.common is None else relaxation_row(conflict.common, limits, default),
    }


def relaxation_row(relaxation: Relaxation, limits: list[Limit], default: int | None) -> dict[str, Any]:
    """Return the limits that would let a candidate in."""
    return {
        "candidate": point_name(relaxation.candidate),
        "default": relaxation.candidate == default,
        "share": relaxation.share,
        "limits": [
            {
                "label": limits[i].label, **units_of(limits[i].unit, limits[i].scale), "sense": limits[i].sense,
                "limit": in_file(limits[i].limit, limits[i].scale), "relaxed": in_file(value, limits[i].scale),
            }
            for i, value in relaxation.changes
        ],
    }  # fmt: skip


def cost_row(cost: Cost, limits: list[Limit], objectives: tuple[Objective, ...]) -> dict[str, Any]:
    """Return the best value of an objective that the search found with a limit and without it."""
    objective = objectives[cost.objective]
    return {
        "limit": limits[cost.limit].label,
        "objective": objective.label,
        "unit": objective.metric.unit,
        "with": cost.kept,
        "without": cost.without,
    }


def comparison_row(row: Comparison) -> dict[str, Any]:
    """Return one line of the Default / Tuned table."""
    quantity = row.quantity
    metric = quantity.metric.metric
    return {
        "label": quantity.label,
        "metric": quantity.metric.text,
        "definition": metric.definition,
        "risk": RISKS[quantity.risk.name].definition,
        "scenario": quantity.scenario,
        "unit": quantity.metric.unit,
        "kind": "objective" if row.limit is None else "constraint",
        "limit": row.limit,
        "default": row.default.as_dict(),
        "tuned": row.tuned.as_dict(),
        "difference": row.difference.as_dict(),
        "verdict": row.verdict,
    }


def known_row(row: KnownComparison) -> dict[str, Any]:
    """Return the line of a requirement in SI units: numbers without intervals, null where a value is infinite."""
    requirement = row.requirement
    finite = isfinite(row.default) and isfinite(row.tuned)
    default, tuned = (float(requirement.in_file(value)) for value in (row.default, row.tuned))
    return {
        "label": requirement.label,
        "quantity": requirement.quantity,
        **requirement.units(),
        "kind": "requirement",
        "limit": float(requirement.in_file(requirement.limit)),
        "sense": requirement.sense,
        "hard": requirement.hard,
        "default": known_value(default),
        "tuned": known_value(tuned),
        "difference": known_value(tuned - default if finite else None),
        "verdict": row.verdict,
    }


def known_value(value: float | None) -> dict[str, float | None]:
    """Return a number in the shape of an estimate, without an interval; null where it is infinite."""
    return {"value": value if value is not None and isfinite(value) else None, "low": None, "high": None}


def variables(outcome: "Outcome") -> list[dict[str, Any]]:
    """Return every decision variable with unit, range and its default and tuned value."""
    study = outcome.study
    default, tuned = outcome.gains(0), outcome.gains(outcome.tuned)
    known = {gain.column: gain for gain in gain_addresses(study.system.cascade)}
    return [
        {
            "name": variable.name,
            "symbol": known[columns[0]].info.symbol,
            "meaning": known[columns[0]].info.meaning,
            "unit": known[columns[0]].unit,
            "low": variable.low,
            "high": variable.high,
            "scale": variable.scale,
            "natural_ends": [end for end in ENDS if natural_end(study, i, getattr(variable, end))],
            "default": float(default[columns[0]]),
            "tuned": float(tuned[columns[0]]),
        }
        for i, (variable, columns) in enumerate(zip(study.space.variables, study.space.columns, strict=True))
    ]
