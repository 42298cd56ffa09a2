"""Probabilities that points satisfy constraints, computed where they decide a choice.

A point is chosen by its value times its probability. The probability under constraints that are computed without flying is the
dearest part of it, and 1 bounds it, so of some 450 points of a pool only the 70 with the largest products of value and bound need
it. The same holds for points that are drawn by their probability.
"""

from collections.abc import Callable, Sequence
from math import prod
from typing import NamedTuple

import numpy as np

from plant.threads import parallel_map
from tuner.search.gaussian_process import GaussianProcess

Array = np.ndarray
# Points of an order that are evaluated again at once.
N_LEADING = 8
# Points checked without flying: for each that is still to be picked, and at least. One by one takes far longer.
CHECKS_PER_PICK, MIN_CHECKS = 3, 32
# Probabilities that are worked out at once, at first; twice as many each time.
N_EXACT = 64
# Least weight of a point that is drawn, points that are looked at together, and those by which constraints are sorted.
MIN_WEIGHT, SAMPLING_BATCH, SORTING_BATCH = 1e-12, 256, 64


class ConstraintModel(NamedTuple):
    """The model of a constraint that is satisfied up to a threshold."""

    model: GaussianProcess
    threshold: float

    def probability(self, points: Array) -> Array:
        """Return the probability (p,) of satisfying it at points (p, d)."""
        return self.model.posterior(points).cdf(self.threshold)


def probability_of_feasibility(constraints: Sequence[ConstraintModel], pool: Array) -> Array:
    """Return the probability (p,) of satisfying all constraints: taken as independent, at points (p, d)."""
    probabilities = parallel_map(lambda limit: limit.probability(pool), constraints)
    return prod(probabilities, start=np.ones(len(pool)))


def sample_feasible(
    constraints: Sequence[ConstraintModel], points: Array, count: int, rng: np.random.Generator
) -> Array:
    """Return some of the points (n, d), drawn by their probability of feasibility.

    Sampling without replacement: P. S. Efraimidis, P. G. Spirakis, Information Processing Letters 97(5):181-185, 2006. The
    smallest quotients of an exponential draw and the probability count, and the draw alone is a lower bound of it.
    """
    draws = rng.exponential(size=len(points))
    order, quotients, largest = np.argsort(draws, kind="stable"), np.full(len(points), np.inf), np.inf
    few = points[order[:SORTING_BATCH]]
    # Those that refuse most come first and leave few points to the others.
    constraints = sorted(constraints, key=lambda limit: float(limit.probability(few).sum()))
    for begin in range(0, len(points), SAMPLING_BATCH):
        rows = order[begin : begin + SAMPLING_BATCH]
        rows = rows[draws[rows] <= largest]
        product = np.ones(len(rows))
        for limit in constraints:
            product *= limit.probability(points[rows])
            may = draws[rows] / np.maximum(product, MIN_WEIGHT) <= largest
            rows, product = rows[may], product[may]
        quotients[rows] = draws[rows] / np.maximum(product, MIN_WEIGHT)
        largest = np.partition(quotients, count - 1)[count - 1]
    return points[np.argsort(quotients, kind="stable")[:count]]


class FeasibilityProbabilities:
    """Probabilities of feasibility over a pool of candidates: 0 or 1 once checked.

    is_selectable (p,): mask of the candidates to choose from; is_checked (p,): mask of those that the first analysis has checked.

    Args:
        pool: candidates (p, d).
        flown: their probability (p,) of satisfying the constraints that need flights.
        screens: constraints computed without flights.
    """

    def __init__(self, pool: Array, flown: Array, screens: "Sequence[DeterministicConstraints]") -> None:
        self._pool, self._flown, self._screens = pool, flown, screens
        self.is_selectable = np.ones(len(pool), dtype=bool)
        self.is_checked = np.full(len(pool), not screens)
        self._levels: list[tuple[list[ConstraintModel], Array]] = [([], np.zeros(0))] * len(screens)
        self._refresh()

    def _refresh(self) -> None:
        """Take the models of all analyses as they are now.

        Every probability is open again, and at most that of the flights.
        """
        for level, screen in enumerate(self._screens):
            models, before = screen.models, self._levels[level][0]
            if models is not before or not len(self._levels[level][1]):
                self._levels[level] = models, np.full(len(self._pool), np.nan)
        self._has_models = ~self.is_checked
        self._bound, self._is_exact = self._flown.copy(), np.zeros(len(self._pool), dtype=bool)

    def exact(self, rows: Array) -> Array:
        """Return the probabilities (k,) of rows."""
        open_rows = rows[~self._is_exact[rows]]
        if len(open_rows):
            product = np.ones(len(open_rows))
            for level in range(len(self._screens)):
                with_models = self._has_models[open_rows] if level == 0 else np.full(len(open_rows), True)
                product[with_models] *= self._of_level(level, open_rows[with_models])
            self._bound[open_rows] = self._flown[open_rows] * product
            self._is_exact[open_rows] = True
        return self._bound[rows]

    def _of_level(self, level: int, rows: Array) -> Array:
        """Return the probabilities (k,) of satisfying an analysis.

        Those of a model are computed once.
        """
        models, probabilities = self._levels[level]
        new = rows[np.isnan(probabilities[rows])]
        if len(new):
            probabilities[new] = probability_of_feasibility(models, self._pool[new])
        return probabilities[rows]

    def order(self, values: Array, unchecked: int = 0) -> Array:
        """Return the selectable rows (k,) by value (p,) times probability, largest first.

        The first `N_LEADING` rows are so for certain, and so is a number of unchecked ones; those behind them go by bounds.
        """
        selectable, count = np.flatnonzero(self.is_selectable), N_EXACT
        while True:
            bound = self._bound[selectable]
            order = selectable[np.lexsort((-bound, -values[selectable] * bound))]
            leading = np.concatenate([order[:N_LEADING], order[~self.is_checked[order]][:unchecked]])
            if self._is_exact[leading].all():
                return order
            self.exact(order[~self._is_exact[order]][:count])
            count *= 2

    def check(self, values: Array, needed: int, reserve: int = 0) -> None:
        """Check the first rows of an order by the first analysis.

        Args:
            values: acquisition values (p,).
            needed: number still to be picked.
            reserve: number that must be left then.
        """
        count = max(CHECKS_PER_PICK * needed, MIN_CHECKS)
        order = self.order(values, count)
        rows = order[~self.is_checked[order]][:count]
        self.is_checked[rows] = True
        is_feasible = self._screens[0].is_feasible(self._pool[rows])
        if is_feasible.sum() + len(order) - len(rows) < needed + reserve:
            # Too few candidates remain: infeasible ones stay selectable.
            return
        self.is_selectable[rows] = is_feasible
        self._refresh()

    def confirm(self, rows: list[int]) -> list[int]:
        """Return the rows that satisfy the longer analyses.

        All rows stay where the pool has too few others.
        """
        needed = len(rows)
        for screen in self._screens[1:]:
            is_feasible = screen.is_feasible(self._pool[rows])
            if np.count_nonzero(self.is_selectable) < needed - np.count_nonzero(is_feasible):
                return rows
            if not is_feasible.all():
                rows = [row for row, feasible in zip(rows, is_feasible, strict=True) if feasible]
                self._refresh()
        return rows


class DeterministicConstraints:
    """Constraints computed without flying, once for each point. points (n, d), excess (n, h): of all points so far.

    evaluate: points -> excess, 0 or less where they hold. model: points and excess -> models of the constraints ever violated.
    """

    def __init__(
        self, evaluate: Callable[[Array], Array], model: Callable[[Array, Array], list[ConstraintModel]]
    ) -> None:
        self._evaluate, self._model = evaluate, model
        self._rows: dict[bytes, int] = {}
        self._models: tuple[int, list[ConstraintModel]] = (0, [])

    @property
    def models(self) -> list[ConstraintModel]:
        """Models of the constraints, from all points so far."""
        if self._models[0] < len(self._rows):
            # Values far from the threshold do not locate it.
            self._models = (len(self._rows), self._model(self.points, np.clip(self.excess, -1.0, 1.0)))
        return self._models[1]

    def is_feasible(self, points: Array) -> Array:
        """Return a mask (n,) of the points (n, d) that satisfy all."""
        new = {point.tobytes(): point for point in points if point.tobytes() not in self._rows}
        if new:
            added = np.array(list(new.values()))
            # Margins come from LAPACK: their last digits must not decide the course of the search.
            excess = np.round(self._evaluate(added), 9)
            self.points = np.concatenate([self.points, added]) if self._rows else added
            self.excess = np.concatenate([self.excess, excess]) if self._rows else excess
            self._rows |= {key: len(self._rows) + i for i, key in enumerate(new)}
        if not len(points):
            return np.ones(0, dtype=bool)
        return np.all(self.excess[[self._rows[point.tobytes()] for point in points]] <= 0.0, axis=1)
