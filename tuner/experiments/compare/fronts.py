"""The fronts of the contenders on the flights of the comparison: how large they are, and what each offers under a limit.

A front is what a contender's own search and held-out check left. Its points are flown again on the scenarios of the
comparison, which had no part in that; what breaks a constraint or is dominated on these flights is left out. The best point
under a limit is picked on held-out values, and its value is that on the flights of the comparison.

The hypervolume of a front is the share it dominates of the box between the ideal point of the union of all fronts (the
smallest value of each objective) and the reference, 1.1 times the nadir of that union (the largest value of each
objective): one box for all, stated in the results. Its interval is a bootstrap over scenarios with the points of the front
held fixed; every front sees the same resamples, so fronts are compared in pairs. A hypervolume has no standard error in
the sample, so this is a percentile interval: on straight fronts of 12 and 30 points of lognormal values with 256 to 1024
flights (CVaR 0.8 and mean, 200 to 300 repetitions) it holds the true size in 92 to 94 %, that of a difference in 96 to 97 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from objectives.problem import Objective
from objectives.risk import RELEVANT, classify_difference, replicates_on, resampled_scenarios, within
from objectives.risk.differences import BETTER, WORSE
from plant.seeds import generator
from plant.ties import first_smallest
from tuner.analysis.final_flights import FRONT_REPLICATES
from tuner.documents.parts import SampledValue
from tuner.experiments.compare.flying import ComparedPoint, Flown
from tuner.search.front import non_dominated
from tuner.study.comparison import ComparisonStudy

REFERENCE = 1.1
# Levels of the other objective at which the best value is told: these quantiles of it over the points of all fronts.
LEVELS = (0.25, 0.5, 0.75)
TAILS = (0.025, 0.975)


@dataclass(frozen=True)
class Front:
    """The feasible non-dominated points of a contender on the comparison's flights.

    Attributes:
        points: Names of the points.
        candidates: Indices (n,) in the contender's search, -1 for gains as given.
        gains: Gains (n, gains).
        values: Values (n, objectives).
        low: Lower ends of their intervals (n, objectives).
        high: Upper ends of their intervals (n, objectives).
        samples: Scores (n, flights) that count for each objective.
        picked: Values (n, objectives) by which a point is picked, None where there are none but those compared.
        lost: Flights (n,) of the comparison that did not reach their end.
        broken: Number of points left out because they break a constraint.
    """

    points: list[str]
    candidates: np.ndarray
    gains: np.ndarray
    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    samples: list[np.ndarray]
    picked: np.ndarray | None
    lost: np.ndarray
    broken: int = 0


@dataclass(frozen=True)
class Volumes:
    """Hypervolumes of the fronts.

    Attributes:
        ideal: Ideal end of the box (objectives,).
        reference: Reference end of the box (objectives,).
        volumes: Share of the box for each front.
        differences: Differences of two shares as (first, second, share).
        relevant: Share of a share from which a difference matters.
    """

    ideal: np.ndarray
    reference: np.ndarray
    volumes: list[SampledValue]
    differences: list[tuple[int, int, SampledValue]]
    relevant: float = RELEVANT

    def larger(self, first: int, second: int, difference: SampledValue) -> int | None:
        """Return the larger front of two by their difference; None where it shows neither."""
        value, low, high = difference
        word = classify_difference(self.volumes[first].value, -value, -high, -low, self.relevant)
        return {BETTER: second, WORSE: first}.get(word)


@dataclass(frozen=True)
class Best:
    """The point picked for an objective with another held to a limit. rows: for each front a row of it, or None."""

    objective: int
    subject_to: int
    limit: float
    rows: list[int | None]


def front_of(study: ComparisonStudy, entries: Sequence[ComparedPoint], flown: Flown) -> Front:
    """Return the feasible, non-dominated points among entries of one contender; flown: of these entries alone."""
    objectives = study.base.objectives
    drawn = _resamples(study.seed, flown.origin)
    samples = [flown.samples(i, objective.scenario) for i, objective in enumerate(objectives)]
    values, low, high = (np.empty((len(entries), len(objectives))) for _ in range(3))
    for i, objective in enumerate(objectives):
        values[:, i] = objective.risk.apply(samples[i])
        part = within(drawn, flown.origin, objective.scenario)
        low[:, i], high[:, i] = objective.interval(samples[i], part)
    feasible = np.flatnonzero(_feasible(study, flown, drawn))
    best = feasible[non_dominated(values[feasible])]
    # Where there is one point there is nothing to pick among.
    picked = values if len(entries) == 1 else _picked(entries, len(objectives))
    return Front(
        points=[entries[k].point for k in best],
        candidates=np.array([entries[k].candidate for k in best], dtype=int),
        gains=np.array([entries[k].row for k in best]),
        values=values[best],
        low=low[best],
        high=high[best],
        samples=[part[best] for part in samples],
        picked=None if picked is None else picked[best],
        lost=flown.failed[best].sum(axis=1),
        broken=len(entries) - len(feasible),
    )


def _picked(entries: Sequence[ComparedPoint], objectives: int) -> np.ndarray | None:
    rows = [entry.picked for entry in entries if entry.picked is not None]
    return np.array(rows).reshape(-1, objectives) if len(rows) == len(entries) else None


def _feasible(study: ComparisonStudy, flown: Flown, drawn: np.ndarray) -> np.ndarray:
    """Return a mask (entries,) of those that satisfy every constraint on flights; at the study's confidence."""
    feasible = np.ones(len(flown.scores), dtype=bool)
    labels = [quantity.label for quantity in study.quantities]
    for entry in study.base.constraints:
        if entry.floor:
            continue
        objective = entry.objective
        samples = flown.samples(labels.index(objective.label), objective.scenario)
        part = within(drawn, flown.origin, objective.scenario)
        high = objective.risk.apply(samples)
        feasible &= (
            high if entry.rests_on_value else objective.interval(samples, part, entry.confidence).high
        ) <= entry.most
    return feasible


def _resamples(root: int, origin: np.ndarray) -> np.ndarray:
    return resampled_scenarios(generator(root, "bootstrap/contest-front", 0), FRONT_REPLICATES, origin)


def volumes_of(
    fronts: list[Front],
    objectives: tuple[Objective, ...],
    origin: np.ndarray,
    root: int,
    relevant: float = RELEVANT,
) -> Volumes | None:
    """Measure all fronts in one box; None where every front is empty. origin (flights,): scenario of each flight."""
    union = np.concatenate([front.values for front in fronts], axis=0)
    if len(union) == 0:
        return None
    ideal, reference = union.min(axis=0), REFERENCE * union.max(axis=0)
    # An objective that is the same everywhere spans no box; a unit then stands in for it.
    reference = np.where(reference > ideal, reference, ideal + 1.0)
    drawn = _resamples(root, origin)
    parts = [within(drawn, origin, objective.scenario) for objective in objectives]
    replicates = [_replicates(front, objectives, parts, ideal, reference) for front in fronts]
    values = [volume(front.values, ideal, reference) for front in fronts]
    differences = [
        (a, b, _estimate(values[b] - values[a], replicates[b] - replicates[a]))
        for a, b in combinations(range(len(fronts)), 2)
    ]
    volumes = [_estimate(value, drawn) for value, drawn in zip(values, replicates, strict=True)]
    return Volumes(ideal, reference, volumes, differences, relevant)


def volume(values: np.ndarray, ideal: np.ndarray, reference: np.ndarray) -> float:
    """Return the share of a box that points (n, m) dominate.

    The box reaches from ideal to reference (m,); points below ideal count as on it.
    """
    from moocore import hypervolume

    scaled = np.maximum(values - ideal, 0.0) / (reference - ideal)
    scaled = scaled[np.all(scaled < 1.0, axis=1)]
    return float(hypervolume(scaled, ref=np.ones(len(ideal)))) if len(scaled) else 0.0


def _replicates(
    front: Front,
    objectives: tuple[Objective, ...],
    parts: list[np.ndarray],
    ideal: np.ndarray,
    reference: np.ndarray,
) -> np.ndarray:
    """Return the volume of the front on each resample (replicates,); parts: for each objective those of its flights."""
    if not front.points:
        return np.zeros(FRONT_REPLICATES)
    risks = [
        replicates_on(samples, objective.risk, part)
        for objective, samples, part in zip(objectives, front.samples, parts, strict=True)
    ]
    drawn = np.stack(risks, axis=-1)
    return np.array([volume(drawn[:, r], ideal, reference) for r in range(FRONT_REPLICATES)])


def _estimate(value: float, replicates: np.ndarray) -> SampledValue:
    low, high = np.quantile(replicates, TAILS, axis=-1)
    return SampledValue(float(value), float(low), float(high))


def best_under(fronts: list[Front], objectives: int) -> list[Best]:
    """Return the picks for each objective at three levels of the other.

    Nothing for a number of objectives other than 2, or where a front has no values to pick by but those that are
    compared.
    """
    values_by_front = [front.picked for front in fronts if front.picked is not None]
    if objectives != 2 or len(values_by_front) < len(fronts) or not any(map(len, values_by_front)):
        return []
    union = np.concatenate(values_by_front, axis=0)
    best = []
    for objective, other in ((0, 1), (1, 0)):
        for limit in np.quantile(union[:, other], LEVELS, axis=0):
            rows = [_best_row(values, objective, other, float(limit)) for values in values_by_front]
            best.append(Best(objective, other, float(limit), rows))
    return best


def _best_row(values: np.ndarray, objective: int, other: int, limit: float) -> int | None:
    allowed = np.flatnonzero(values[:, other] <= limit)
    return int(allowed[first_smallest(values[allowed, objective])]) if len(allowed) else None
