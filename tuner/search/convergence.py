"""Convergence of a search: the increase of its hypervolume, and the generations that it would take to converge.

Only the recorded hypervolumes decide, so a replayed search stops where it stopped. The increase still to come is extrapolated by
least squares: hypervolume = limit - scale n^-a, or limit - scale e^(-n/b), after n generations.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

Array = np.ndarray
# A search has converged where the last quarter of its generations adds no more than this share of the hypervolume.
QUARTER, TOLERANCE = 0.25, 0.02
# Generations from which on a search may be ended: before, a quarter of them is too few to go by.
MIN_GENERATIONS = 12
# Least number of generations with a front in a fit, and largest extrapolation in multiples of the generations made.
MIN_FIT_GENERATIONS, MAX_EXTRAPOLATION = 5, 8
# Exponents a that are tried, and time constants b over the number of generations.
EXPONENTS, CONSTANTS = np.geomspace(0.25, 4.0, 25), np.geomspace(0.05, 2.0, 25)


class StoppingRule(NamedTuple):
    """Largest number of generations of a search.

    converges: it ends before, where it has converged; least: but not before so many generations.
    """

    generations: int
    converges: bool = False
    least: int = MIN_GENERATIONS

    def is_met(self, volumes: Sequence[float]) -> bool:
        """Return true where a search with these hypervolumes, one a generation, ends."""
        if len(volumes) >= self.generations:
            return True
        return self.converges and len(volumes) >= self.least and has_converged(volumes)


class HypervolumeFit(NamedTuple):
    """A hypervolume over generations, limit - scale remainder(n); error: sum of squared residuals."""

    limit: float
    scale: float
    remainder: Callable[[Array], Array]
    error: float

    def evaluate(self, generations: Array) -> Array:
        """Return the hypervolumes after numbers of generations."""
        return self.limit - self.scale * self.remainder(generations)


def last_quarter(generations: int) -> int:
    """Return the number of generations in the last quarter of a search."""
    return max(round(QUARTER * generations), 1)


def last_quarter_improvement(volumes: Sequence[float]) -> float:
    """Return the last quarter's share of the hypervolume; 0 without a front."""
    if len(volumes) < 2 or volumes[-1] <= 0.0:
        return 0.0
    return (volumes[-1] - volumes[-1 - last_quarter(len(volumes))]) / volumes[-1]


def has_converged(volumes: Sequence[float]) -> bool:
    """Return true where a search with a front has converged."""
    return len(volumes) >= MIN_GENERATIONS and volumes[-1] > 0.0 and last_quarter_improvement(volumes) <= TOLERANCE


def generations_to_convergence(volumes: Sequence[float]) -> int | None:
    """Return the number of generations after which the search would converge.

    None where fewer than `MIN_FIT_GENERATIONS` have a front, or beyond `MAX_EXTRAPOLATION` times the generations made.
    """
    fit = _fit(np.asarray(volumes, dtype=float))
    if fit is None:
        return None
    for generations in range(len(volumes) + 1, MAX_EXTRAPOLATION * len(volumes) + 1):
        before, after = fit.evaluate(np.array([generations - last_quarter(generations), generations], dtype=float))
        if after - before <= TOLERANCE * after:
            return generations
    return None


def _fit(volumes: Array) -> HypervolumeFit | None:
    """Return the best fit: to the last three quarters of the generations with a front."""
    with_front = np.flatnonzero(volumes > 0.0)
    tail = with_front[len(with_front) // 4 :]
    if len(tail) < MIN_FIT_GENERATIONS:
        return None
    shapes = [lambda n, a=a: n**-a for a in EXPONENTS]
    shapes += [lambda n, b=b: np.exp(-n / b) for b in CONSTANTS * len(volumes)]
    fits = [_least_squares(tail + 1.0, volumes[tail], shape) for shape in shapes]
    # A front dominates at most the whole box.
    return min((fit for fit in fits if fit.limit <= 1.0), key=lambda fit: fit.error, default=None)


def _least_squares(generations: Array, volumes: Array, remainder: Callable[[Array], Array]) -> HypervolumeFit:
    """Return the least-squares fit of a shape to hypervolumes."""
    regressor = remainder(generations)
    centered = regressor - regressor.mean(axis=0)
    scale = -float((centered * volumes).sum(axis=0) / np.square(centered).sum(axis=0))
    limit = float(volumes.mean(axis=0) + scale * regressor.mean(axis=0))
    return HypervolumeFit(limit, scale, remainder, float(np.square(volumes - limit + scale * regressor).sum(axis=0)))
