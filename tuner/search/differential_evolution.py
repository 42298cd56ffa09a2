"""Differential evolution, rand/1/bin. For one objective that is rugged or has several basins.

R. Storn, K. Price, "Differential evolution: a simple and efficient heuristic for global optimization over continuous spaces",
J. Global Optimization 11:341-359, 1997; points beyond a bound bounce back as in K. Price, R. Storn, J. Lampinen,
"Differential Evolution", Springer 2005, section 4.3.1. It compares candidates only: feasible first, see `constraint_ranking`.
"""

import numpy as np

from plant.seeds import generator
from tuner.search.constraint_ranking import TotalViolation

# Weight of the difference of two points and share of variables that a trial takes from the mutant: Storn and Price 1997
# recommend 0.5, and 0.9 for variables that interact.
WEIGHT, CROSSOVER = 0.5, 0.9


class DifferentialEvolution:
    """Differential evolution, rand/1/bin.

    first: points (n, d) of the first generation; its size is the population, at least 4. seed: of all later draws.
    """

    def __init__(self, first: np.ndarray, n_objectives: int, n_constraints: int, seed: int) -> None:
        assert n_objectives == 1, "differential evolution searches for one objective"
        self._seed = seed
        self._total = TotalViolation(n_constraints)
        self._pending: np.ndarray | None = first.copy()
        # All rivals for each place of the population (generations, n), and their results.
        self._rivals = np.empty((0, *first.shape))
        self._totals = self._values = np.empty((0, len(first)))

    def ask(self) -> np.ndarray:
        """Return the next generation (n, d), points of the unit cube: a rival for each point of the population."""
        if self._pending is None:
            rng = generator(self._seed, "search/differential_evolution", len(self._rivals))
            self._pending = trials(winners(self._rivals, self._totals, self._values), rng)
        return self._pending.copy()

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Record the objective (n, 1) and constraint violations (n, c) of the pending generation."""
        self._rivals = np.concatenate([self._rivals, self.ask()[None]])
        self._totals = np.concatenate([self._totals, self._total.of(violations)[None]])
        self._values = np.concatenate([self._values, values.T])
        self._pending = None

    def retell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Replace the objective (n, 1) and constraint violations (n, c) of all points so far: each place has its best rival."""
        self._totals = self._total.of(violations).reshape(self._totals.shape)
        self._values = values.reshape(self._values.shape)


def winners(rivals: np.ndarray, totals: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the best point (n, d) for each place of a population: of rivals (k, n, d), the last of equal ones.

    totals, values (k, n): violation, and objective where that is equal.
    """
    last_first = np.broadcast_to(-np.arange(len(rivals))[:, None], totals.shape)
    best = np.lexsort((last_first, values, totals), axis=0)[0]
    return rivals[best, np.arange(rivals.shape[1])]


def trials(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a trial for each of points (n, d) of the unit cube."""
    n, dimensions = points.shape
    base, plus, minus = points[three_others(n, rng)].swapaxes(0, 1)
    mutants = bounce_back(base + WEIGHT * (plus - minus), base, rng)
    taken = rng.uniform(size=(n, dimensions)) < CROSSOVER
    # One variable at least is the mutant's, so that a trial is never the point itself.
    taken[np.arange(n), rng.integers(dimensions, size=n)] = True
    return np.where(taken, mutants, points)


def three_others(n: int, rng: np.random.Generator) -> np.ndarray:
    """Return rows (n, 3) of a population: three that differ from each other and from the one they are for."""
    order = np.argsort(rng.uniform(size=(n, n - 1)), axis=1)[:, :3]
    return order + (order >= np.arange(n)[:, None])


def bounce_back(mutants: np.ndarray, base: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Replace variables of mutants beyond 0 or 1: by values between their base's and the bound, all (n, d)."""
    share = rng.uniform(size=mutants.shape)
    low, high = base * share, base + (1.0 - base) * share
    return np.where(mutants < 0.0, low, np.where(mutants > 1.0, high, mutants))
