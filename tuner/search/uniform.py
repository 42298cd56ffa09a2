"""Uniform random search: the baseline. A search that does not beat it over several seeds is not worth its name."""

import numpy as np

from plant.seeds import generator


class Uniform:
    """Uniform random search, independent of results.

    first: points (n, d) of the first generation; its size is the population. seed: of all later draws.
    """

    def __init__(self, first: np.ndarray, n_objectives: int, n_constraints: int, seed: int) -> None:
        self._seed = seed
        self._generation = 0
        self._points = first.copy()

    def ask(self) -> np.ndarray:
        """Return the next generation (n, d), points of the unit cube."""
        return self._points.copy()

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Proceed to the next generation; objectives (n, m) and violations (n, c) have no effect."""
        self._generation += 1
        self._points = self.sample(len(self._points))

    def sample(self, count: int) -> np.ndarray:
        """Return points (count, d) of the next generation."""
        return generator(self._seed, "search/random", self._generation).uniform(size=(count, self._points.shape[1]))
