"""The truth about the finalists: re-flown on scenarios that the search never saw, with intervals over scenarios."""

from dataclasses import dataclass

import numpy as np

from objectives.problem import Evaluation, Objective, Problem
from objectives.requirements import Requirement
from objectives.risk import bootstrap_interval, paired_difference
from plant.seeds import generator
from tuner.search.front import non_dominated

# Bootstrap replicates for the error bars of the front, and for the Default / Tuned table.
FRONT_REPLICATES, TABLE_REPLICATES = 400, 2000


@dataclass(frozen=True)
class Estimate:
    """A risk on held-out scenarios with its 95 % bootstrap interval."""

    value: float
    low: float
    high: float

    def as_dict(self) -> dict[str, float]:
        """Return the three numbers by name."""
        return {"value": self.value, "low": self.low, "high": self.high}


@dataclass(frozen=True)
class Comparison:
    """One quantity of the tuned point against the default; difference: tuned minus default, paired over scenarios."""

    quantity: Objective
    limit: float | None
    default: Estimate
    tuned: Estimate
    difference: Estimate

    @property
    def verdict(self) -> str:
        """Say in words what the interval of the difference, or the limit, allows to say."""
        if self.limit is not None:
            return "kept" if self.tuned.value <= self.limit else "broken"
        if self.difference.high < 0.0:
            return "better"
        return "worse" if self.difference.low > 0.0 else "no clear difference"


@dataclass(frozen=True)
class KnownComparison:
    """One requirement of the tuned point against the default: numbers without intervals, for nothing was sampled."""

    requirement: Requirement
    default: float
    tuned: float

    @property
    def verdict(self) -> str:
        """Say whether the tuned point keeps it."""
        return "kept" if self.requirement.kept(np.array([self.tuned]))[0] else "broken"


@dataclass(frozen=True)
class Finalists:
    """Held-out results; row 0 is the default, the others are the front of the search.

    evaluation: of all rows; low, high (rows, objectives): intervals; feasible, non_dominated: masks over the rows, the
    second among the feasible rows behind the default.
    """

    evaluation: Evaluation
    low: np.ndarray
    high: np.ndarray
    feasible: np.ndarray
    non_dominated: np.ndarray


def judge(problem: Problem, evaluation: Evaluation, root: int) -> Finalists:
    """Put intervals on the held-out values of all finalists and find who stays on the front."""
    low, high = np.empty_like(evaluation.values), np.empty_like(evaluation.values)
    for i, objective in enumerate(problem.objectives):
        samples = evaluation.samples(i, objective.scenario)
        draw = generator(root, "bootstrap/front", i)
        low[:, i], high[:, i] = bootstrap_interval(samples, objective.risk, draw, FRONT_REPLICATES)
    feasible = np.all(evaluation.violations <= 0.0, axis=1)
    best = np.zeros(len(feasible), dtype=bool)
    rows = 1 + np.flatnonzero(feasible[1:])
    best[rows] = non_dominated(evaluation.values[rows])
    return Finalists(evaluation, low, high, feasible, best)


def compare(problem: Problem, finalists: Finalists, tuned: int, root: int) -> list[Comparison]:
    """Compare a finalist with the default on every objective and constraint, flight by flight on the same scenarios."""
    rows = []
    limits = [None] * len(problem.objectives) + [constraint.most for constraint in problem.constraints]
    for i, (quantity, limit) in enumerate(zip(problem.quantities, limits, strict=True)):
        samples = finalists.evaluation.samples(i, quantity.scenario)[[0, tuned]]
        values = quantity.risk.apply(samples)
        low, high = bootstrap_interval(samples, quantity.risk, generator(root, "bootstrap/table", i), TABLE_REPLICATES)
        paired = paired_difference(
            samples[1], samples[0], quantity.risk, generator(root, "bootstrap/paired", i), TABLE_REPLICATES
        )
        default, best = (Estimate(float(values[k]), float(low[k]), float(high[k])) for k in (0, 1))
        difference = Estimate(float(paired.difference), float(paired.low), float(paired.high))
        rows.append(Comparison(quantity, limit, default, best, difference))
    return rows


def compare_known(problem: Problem, finalists: Finalists, tuned: int) -> list[KnownComparison]:
    """Compare a finalist with the default on every requirement."""
    values = finalists.evaluation.requirements[[0, tuned]]
    return [
        KnownComparison(requirement, float(values[0, i]), float(values[1, i]))
        for i, requirement in enumerate(problem.requirements)
    ]
