"""CMA-ES. For one objective that is smooth where it matters, also with gains that interact.

N. Hansen, "The CMA evolution strategy: a tutorial", arXiv:1604.00772, 2016, as implemented by the package cmaes (M. Nomura,
M. Shibata, arXiv:2402.01373). It sees ranks only: feasible candidates by their value, then the others by their violation.
"""

import numpy as np
from cmaes import CMA

from plant.seeds import generator
from tuner.search.constraint_ranking import TotalViolation, feasibility_order

# Standard deviation of a uniform variable on [0, 1]. The first generation, spread over the cube, is a sample of about the
# distribution that the strategy starts from, and is told to it as any other.
SPREAD = 12.0**-0.5


class CmaEs:
    """CMA-ES, started again elsewhere once it has converged.

    first: points (n, d) of the first generation; its size is the population. seed: of all later draws.
    """

    def __init__(self, first: np.ndarray, n_objectives: int, n_constraints: int, seed: int) -> None:
        assert n_objectives == 1, "CMA-ES searches for one objective"
        self._seed = seed
        self._total = TotalViolation(n_constraints)
        self._population, self._dimensions = first.shape
        self._starts = 0
        self._strategy = self._started(np.full(first.shape[1], 0.5))
        self._points = first.copy()

    def ask(self) -> np.ndarray:
        """Return the next generation (n, d), points of the unit cube."""
        return self._points.copy()

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Record the objective (n, 1) and constraint violations (n, c) of the pending generation."""
        order = feasibility_order(values[:, 0], self._total.of(violations))
        self._strategy.tell([(self._points[row], float(rank)) for rank, row in enumerate(order)])
        if self._strategy.should_stop():
            draw = generator(self._seed, "search/cmaes/mean", self._starts)
            self._strategy = self._started(draw.uniform(size=self._dimensions))
        self._points = np.stack([self._strategy.ask() for _ in range(self._population)], axis=0)

    def retell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Change nothing.

        A strategy keeps no candidates, and the next generation is ranked by its own results.
        """

    def _started(self, mean: np.ndarray) -> CMA:
        """Return a strategy started around mean (d,), as wide as the cube."""
        seed = int(generator(self._seed, "search/cmaes", self._starts).integers(2**32))
        self._starts += 1
        bounds = np.tile([0.0, 1.0], (self._dimensions, 1))
        return CMA(mean, SPREAD, bounds=bounds, seed=seed, population_size=self._population)
