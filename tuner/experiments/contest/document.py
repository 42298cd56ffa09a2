"""contest.json: what a contest found, in numbers and sentences; the keys are told in results/README.md."""

from typing import Any

import numpy as np

from objectives.risk import RISKS
from plant.gains import gain_addresses
from tuner.analysis.held_out import Estimate
from tuner.experiments.contest.comparison import Difference
from tuner.experiments.contest.cost import MEANING, Cost
from tuner.experiments.contest.fronts import Best
from tuner.experiments.contest.published import Cell
from tuner.experiments.contest.result import Result
from tuner.experiments.contest.words import sentences
from tuner.study.contest import Quantity
from tuner.study.processor_cost.cost import MEANING as PROCESSOR_MEANING

Document = dict[str, Any]

BOX = "share that a front dominates of the box from ideal to reference, 1.1 times the nadir of the union of all fronts"


def contest_document(result: Result, warnings: list[str]) -> Document:
    """Return the content of contest.json."""
    contest = result.contest
    return {
        "feasible": all(own.feasible for own in result.prepared),
        "ending": [text for own in result.prepared for text in own.ending],
        "title": contest.title,
        "description": contest.description,
        "study": contest.path.name,
        "seed": contest.seed,
        "flights": result.flights,
        "stream": contest.stream,
        "compared_on": [{"scenario": s.spec.name, "flights": s.held_out, "duration": s.spec.duration} for s in contest.scenarios],
        "wall_seconds": result.seconds,
        "contenders": [contender_row(result, k) for k in range(len(result.names))],
        "quantities": [quantity_row(quantity) for quantity in contest.quantities],
        "estimates": [
            {"contender": name, "quantity": quantity.label, **result.comparison.estimates[k][i].as_dict()}
            for k, name in enumerate(result.names)
            for i, quantity in enumerate(contest.quantities)
        ],
        "differences": [difference_row(result, entry) for entry in result.comparison.differences],
        "fronts": fronts_part(result),
        "best_under": [best_row(result, best) for best in result.best_under],
        "published": [cell_row(result, cell) for cell in result.cells],
        "claims": claims_part(result),
        "words": sentences(result),
        "warnings": warnings,
    }  # fmt: skip


def contender_row(result: Result, k: int) -> Document:
    """Return what there is to know of a contender."""
    own, study, cost = result.prepared[k], result.prepared[k].contender.study, result.costs[k]
    cascade = study.system.cascade
    searched = [entry.search for entry in study.scenarios]
    return {
        "name": own.contender.name,
        "slug": own.contender.slug,
        "laws": {"position": cascade.position.name, "attitude": cascade.attitude.name},
        "airframe": study.airframe.name,
        "tuned": own.contender.tuned,
        "feasible": own.feasible,
        "folder": own.folder,
        "point": own.entry.point,
        "pick": {"rule": study.pick if own.contender.tuned else None, "why": own.why},
        "budget": {
            "population": study.search.population,
            "generations": study.search.generations,
            "flights": study.search.population * study.search.generations * sum(searched),
        }
        if own.contender.tuned
        else None,
        "gains": {
            gain.address: {"value": float(own.entry.row[gain.column]), "unit": gain.unit} for gain in gain_addresses(cascade)
        },
        "searched": [variable.name for variable in study.space.variables],
        "cost": {
            "operations": cost.operations, "position": cost.position, "attitude": cost.attitude, "meaning": MEANING,
            "processor": processor_row(cost, study.system.timing.control_period),
        },
        "on_bounds": [vars(entry) for entry in result.bounds[k]],
        "failures": float(result.flown.failed[k].mean(axis=0)),
    }  # fmt: skip


def processor_row(cost: Cost, control_period: float) -> Document | None:
    """Return instructions and bytes on a microcontroller, a step and a second; None where they are not known."""
    known = cost.processor
    if known is None:
        return None
    return {
        **known.as_dict(), "instructions_per_second": known.per_second(control_period), "meaning": PROCESSOR_MEANING,
    }  # fmt: skip


def quantity_row(quantity: Quantity) -> Document:
    """Return what a quantity is."""
    objective = quantity.objective
    return {
        "label": quantity.label,
        "metric": objective.metric.text,
        "unit": objective.metric.unit,
        "risk": objective.risk.name,
        "level": objective.risk.level,
        "scenario": objective.scenario,
        "definition": objective.metric.metric.definition,
        "risk_definition": RISKS[objective.risk.name].definition,
        "kind": quantity.kind,
        "limit": quantity.limit,
    }


def difference_row(result: Result, entry: Difference) -> Document:
    """Return the paired difference of two contenders in one quantity."""
    winner = entry.winner
    return {
        "first": result.names[entry.first],
        "second": result.names[entry.second],
        "quantity": result.contest.quantities[entry.quantity].label,
        "difference": entry.estimate.value,
        "low": entry.estimate.low,
        "high": entry.estimate.high,
        "verdict": "no clear difference" if winner is None else f"{result.names[winner]} is lower",
        "lower": None if winner is None else result.names[winner],
    }


def fronts_part(result: Result) -> Document | None:
    """Return box and sizes of the fronts, or None where nothing was tuned."""
    volumes = result.volumes
    if volumes is None:
        return None
    labels = [objective.label for objective in result.contest.base.objectives]
    return {
        "objectives": labels,
        "ideal": dict(zip(labels, volumes.ideal.tolist(), strict=True)),
        "reference": dict(zip(labels, volumes.reference.tolist(), strict=True)),
        "meaning": BOX,
        "sizes": [
            {"contender": name, "points": len(front.points), "broken": front.broken}
            for name, front in zip(result.names, result.fronts, strict=True)
        ],
        "hypervolume": [
            {"contender": name, **entry.as_dict()} for name, entry in zip(result.names, volumes.volumes, strict=True)
        ],
        "differences": [
            {
                "first": result.names[a], "second": result.names[b], "difference": apart.value, "low": apart.low,
                "high": apart.high, "larger": _larger(result, a, b, apart),
            }
            for a, b, apart in volumes.differences
        ],
    }  # fmt: skip


def _larger(result: Result, first: int, second: int, apart: Estimate) -> str | None:
    if apart.low > 0.0:
        return result.names[second]
    return result.names[first] if apart.high < 0.0 else None


def best_row(result: Result, best: Best) -> Document:
    """Return what every front offers under a limit; None stands for nothing."""
    labels = [objective.label for objective in result.contest.base.objectives]
    rows = []
    for name, front, row in zip(result.names, result.fronts, best.rows, strict=True):
        ends = (
            [None] * 3
            if row is None
            else [float(part[row, best.objective]) for part in (front.values, front.low, front.high)]
        )
        point = None if row is None else front.points[row]
        rows.append({"contender": name, "value": ends[0], "low": ends[1], "high": ends[2], "point": point})
    return {
        "objective": labels[best.objective], "subject_to": labels[best.subject_to], "limit": best.limit, "rows": rows,
    }  # fmt: skip


def cell_row(result: Result, cell: Cell) -> Document:
    """Return a printed number beside our distribution."""
    entry = cell.published
    low, median, high = (float(point) for point in np.asarray(cell.points))
    return {
        "contender": result.names[cell.contender],
        "contenders": list(entry.contenders),
        "metric": entry.metric.text,
        "unit": entry.metric.unit,
        "scenario": entry.scenario,
        "quantity": entry.objective.label,
        "value": entry.value,
        "source": entry.source,
        "fitted": entry.fitted,
        "mean": cell.mean.value,
        "low": cell.mean.low,
        "high": cell.mean.high,
        "p2_5": low,
        "median": median,
        "p97_5": high,
        "percentile": cell.percentile,
        "inside": cell.inside,
    }


def claims_part(result: Result) -> list[Document]:
    """Return every claim with its rulings."""
    quantities = result.contest.quantities
    return [
        {
            "text": judged.claim.text,
            "better": judged.claim.better,
            "than": list(judged.claim.than),
            "verdict": judged.verdict,
            "rows": [
                {
                    "than": result.names[ruling.than],
                    "quantity": quantities[ruling.quantity].label,
                    "difference": ruling.difference.value,
                    "low": ruling.difference.low,
                    "high": ruling.difference.high,
                    "verdict": ruling.verdict,
                }
                for ruling in judged.rulings
            ],
        }
        for judged in result.claims
    ]
