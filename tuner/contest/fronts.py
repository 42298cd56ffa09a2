"""The fronts of the tuned contenders on held-out scenarios: how large they are, and what each offers under a limit.

The hypervolume of a front is the share it dominates of the box between the ideal point of the union of all fronts (the
smallest value of each objective) and the reference, 1.1 times the nadir of that union (the largest value of each
objective): one box for all, stated in the results. Its interval is a bootstrap over scenarios with the points of the front
held fixed; every front sees the same resamples, so fronts are compared in pairs.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from objectives.problem import Objective
from objectives.risk import bootstrap_replicates
from plant.seeds import generator
from tuner.contest.comparison import estimate_of
from tuner.held_out import FRONT_REPLICATES, Estimate

REFERENCE = 1.1
# Levels of the other objective at which the best value is told: these quantiles of it over the points of all fronts.
LEVELS = (0.25, 0.5, 0.75)


@dataclass(frozen=True)
class Front:
    """The feasible, non-dominated points of a contender on held-out scenarios.

    points: their names; candidates (n,): index in the contender's search, -1 for gains as given; gains (n, gains);
    values, low, high (n, objectives); samples: for each objective the scores (n, flights) that count for it.
    """

    points: list[str]
    candidates: np.ndarray
    gains: np.ndarray
    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    samples: list[np.ndarray]


@dataclass(frozen=True)
class Volumes:
    """ideal, reference (objectives,): the box; volumes: share of it for each front; differences: (first, second, share)."""

    ideal: np.ndarray
    reference: np.ndarray
    volumes: list[Estimate]
    differences: list[tuple[int, int, Estimate]]


@dataclass(frozen=True)
class Best:
    """The best value of an objective with another held to a limit. rows: for each front a row of it, or None."""

    objective: int
    subject_to: int
    limit: float
    rows: list[int | None]


def volumes_of(fronts: list[Front], objectives: tuple[Objective, ...], root: int) -> Volumes | None:
    """Measure all fronts in one box; None where every front is empty."""
    union = np.concatenate([front.values for front in fronts], axis=0)
    if len(union) == 0:
        return None
    ideal, reference = union.min(axis=0), REFERENCE * union.max(axis=0)
    # An objective that is the same everywhere spans no box; a unit then stands in for it.
    reference = np.where(reference > ideal, reference, ideal + 1.0)
    replicates = [_replicates(front, objectives, ideal, reference, root) for front in fronts]
    values = [volume(front.values, ideal, reference) for front in fronts]
    differences = [
        (a, b, estimate_of(values[b] - values[a], replicates[b] - replicates[a]))
        for a, b in combinations(range(len(fronts)), 2)
    ]
    volumes = [estimate_of(value, drawn) for value, drawn in zip(values, replicates, strict=True)]
    return Volumes(ideal, reference, volumes, differences)


def volume(values: np.ndarray, ideal: np.ndarray, reference: np.ndarray) -> float:
    """Return the share of the box from ideal to reference (m,) that points (n, m) dominate; those below ideal count as on it."""
    from moocore import hypervolume

    scaled = np.maximum(values - ideal, 0.0) / (reference - ideal)
    scaled = scaled[np.all(scaled < 1.0, axis=1)]
    return float(hypervolume(scaled, ref=np.ones(len(ideal)))) if len(scaled) else 0.0


def _replicates(
    front: Front, objectives: tuple[Objective, ...], ideal: np.ndarray, reference: np.ndarray, root: int
) -> np.ndarray:
    """Return the volume of the front on each resample (replicates,)."""
    if not front.points:
        return np.zeros(FRONT_REPLICATES)
    risks = []
    for objective, samples in zip(objectives, front.samples, strict=True):
        # Objectives over the same flights see the same resamples of them.
        draw = generator(root, f"bootstrap/hypervolume/{objective.scenario or ''}", 0)
        risks.append(bootstrap_replicates(samples, objective.risk, draw, FRONT_REPLICATES))
    drawn = np.stack(risks, axis=-1)
    return np.array([volume(drawn[:, r], ideal, reference) for r in range(FRONT_REPLICATES)])


def best_under(fronts: list[Front], objectives: int) -> list[Best]:
    """Return the best value of each of two objectives at three levels of the other; nothing for another number of them."""
    union = np.concatenate([front.values for front in fronts], axis=0)
    if objectives != 2 or len(union) == 0:
        return []
    found = []
    for objective, other in ((0, 1), (1, 0)):
        for limit in np.quantile(union[:, other], LEVELS, axis=0):
            rows = [_best_row(front.values, objective, other, float(limit)) for front in fronts]
            found.append(Best(objective, other, float(limit), rows))
    return found


def _best_row(values: np.ndarray, objective: int, other: int, limit: float) -> int | None:
    kept = np.flatnonzero(values[:, other] <= limit)
    return int(kept[np.argmin(values[kept, objective])]) if len(kept) else None
