"""summary.json and gains.json of a run: what was found, in numbers that a person or a program can read."""

from math import isfinite
from typing import TYPE_CHECKING, Any

from objectives.risk import RISKS
from plant.air.air import summary as air_summary
from plant.gains import gain_addresses
from tuner.gains_file import Controller, to_document
from tuner.held_out import Comparison, KnownComparison
from tuner.store.tables import point_name

if TYPE_CHECKING:
    from tuner.conclusion import Outcome


def summary_document(outcome: "Outcome") -> dict[str, Any]:
    """Return the content of summary.json; under "gains_document" that of gains.json."""
    study, finalists = outcome.study, outcome.finalists
    tuned = point_name(int(outcome.candidates[outcome.tuned - 1]))
    table = [comparison_row(row) for row in outcome.table] + [known_row(row) for row in outcome.known]
    last = outcome.generations[-1]
    return {
        "title": study.title,
        "study": study.path.name,
        "tuned": tuned,
        "pick": {"rule": study.pick, "why": outcome.why},
        "flights": outcome.flights,
        "screened": {"candidates": last.screened, "flights": last.flights_saved},
        "wall_seconds": outcome.seconds,
        "search_seconds": {
            "screening": sum(entry.evaluation.screening_seconds for entry in outcome.generations),
            "flights": sum(entry.evaluation.flight_seconds for entry in outcome.generations),
        },
        "held_out": sum(entry.held_out for entry in study.scenarios),
        "front_size": int(finalists.non_dominated.sum()),
        "hypervolume": last.hypervolume,
        "warnings": outcome.warnings,
        "variables": variables(outcome),
        "table": table,
        "air": [{"scenario": entry.spec.name, **air_summary(entry.spec.air)} for entry in study.scenarios],
        "gains_document": gains_document(outcome, tuned, table),
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
    """Return the line of a requirement: numbers without intervals, null where a value is infinite."""
    requirement = row.requirement
    finite = isfinite(row.default) and isfinite(row.tuned)
    return {
        "label": requirement.label,
        "quantity": requirement.quantity,
        "unit": requirement.unit,
        "kind": "requirement",
        "limit": requirement.limit,
        "sense": requirement.sense,
        "hard": requirement.hard,
        "default": known_value(row.default),
        "tuned": known_value(row.tuned),
        "difference": known_value(row.tuned - row.default if finite else None),
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
            "default": float(default[columns[0]]),
            "tuned": float(tuned[columns[0]]),
        }
        for variable, columns in zip(study.space.variables, study.space.columns, strict=True)
    ]


def gains_document(outcome: "Outcome", tuned: str, table: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the content of gains.json for the recommended point."""
    study = outcome.study
    controller = Controller(
        airframe=study.airframe,
        cascade=study.system.cascade,
        options=study.options,
        control_period=study.system.timing.control_period,
        plant_step=study.system.timing.plant_step,
        gains=tuple(float(gain) for gain in outcome.gains(outcome.tuned)),
    )
    provenance = {
        "study": {"name": study.path.name, "title": study.title, "seed": study.seed, "digest": study.digest(), "point": tuned},
        "objectives": [
            {key: row[key] for key in ("label", "unit", "kind", "limit", "default", "tuned", "difference", "verdict")}
            for row in table
        ],
    }  # fmt: skip
    return to_document(controller, provenance)
