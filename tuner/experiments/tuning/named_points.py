"""Points of a front with names: the best within the limits in each objective, the knee, and the smallest step that helps."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from objectives.problem import Objective
from plant.ties import first_smallest
from tuner.documents.parts import Estimate
from tuner.documents.summary import NamedPoint, PointValue
from tuner.experiments.tuning.outcome import Outcome
from tuner.experiments.tuning.recommendation import is_improvement
from tuner.search.front import knee
from tuner.study.comparison import slug_of

KNEE, NEAR = "knee", "near-default"


class Named(NamedTuple):
    """A row of the finalists with its name."""

    name: str
    meaning: str
    row: int


def least_names(objectives: Sequence[Objective]) -> list[str]:
    """Return the names of the best points: "least-" and the metric, with risk and scenario where two judge one metric."""
    metrics = [str(entry.metric) for entry in objectives]
    return [
        f"least-{metric if metrics.count(metric) == 1 else slug_of(entry.label)}"
        for metric, entry in zip(metrics, objectives, strict=True)
    ]


def possible_names(objectives: Sequence[Objective]) -> list[str]:
    """Return every name that a run of a study may give."""
    return [*least_names(objectives), KNEE, NEAR]


def named_rows(
    objectives: Sequence[Objective],
    values: np.ndarray,
    feasible: np.ndarray,
    front: np.ndarray,
    steps: np.ndarray,
    relevant: float,
) -> list[Named]:
    """Return the named rows of finalists, the default first.

    Args:
        objectives: Objectives of the study.
        values: Held-out objectives (rows, m).
        feasible: Mask (rows,) of those that keep every limit.
        front: Rows (k,) of the non-dominated finalists.
        steps: Distances (rows,) of the gains to the default's, in their ranges.
        relevant: Share of the default's values from which a difference matters.
    """
    rows = np.union1d(front, np.flatnonzero(feasible[:1]))
    named = [
        Named(name, f"smallest {entry.label} within the limits", int(rows[first_smallest(values[rows, i])]))
        for i, (name, entry) in enumerate(zip(least_names(objectives), objectives, strict=True))
        if len(rows)
    ]
    if len(objectives) > 1 and len(front) > 2:
        named.append(Named(KNEE, "knee of the front", int(front[knee(values[front])])))
    better = front[is_improvement(values[front], values[0], relevant)] if len(front) else front
    if len(better):
        step = int(better[first_smallest(steps[better])])
        named.append(Named(NEAR, "smallest change of the default's gains that is better", step))
    return named


def named_points(outcome: Outcome) -> list[NamedPoint]:
    """Return the named points of a run that recommends something."""
    if not outcome.feasible:
        return []
    study, finalists = outcome.study, outcome.finalists
    points = study.space.point(study.default_row), outcome.archive.points[outcome.candidates]
    steps = np.concatenate([[0.0], np.linalg.norm(points[1] - points[0], axis=1)])
    front = np.flatnonzero(finalists.non_dominated)
    rows = named_rows(
        study.objectives, finalists.evaluation.values, finalists.feasible, front, steps, study.table.relevant
    )
    return [
        NamedPoint(
            name=entry.name,
            meaning=entry.meaning,
            point=outcome.names[entry.row],
            recommended=entry.row == outcome.tuned,
            objectives=[
                PointValue(
                    label=objective.label,
                    unit=objective.metric.unit,
                    held_out=Estimate(
                        *_parts(finalists.evaluation.values, finalists.low, finalists.high, entry.row, i)
                    ),
                    difference=Estimate(
                        *_parts(finalists.difference, finalists.difference_low, finalists.difference_high, entry.row, i)
                    ),
                )
                for i, objective in enumerate(study.objectives)
            ],
        )
        for entry in rows
    ]


def _parts(value: np.ndarray, low: np.ndarray, high: np.ndarray, row: int, column: int) -> list[float]:
    return [float(part[row, column]) for part in (value, low, high)]
