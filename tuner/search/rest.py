"""Rest of a search: whether its front still moves, and the number of generations after which it would have come to rest.

Only the recorded hypervolumes decide, so a search that is replayed rests where it rested. What is still to come is read off the
curve that fits them best by least squares: hypervolume = limit - scale n^-a, or limit - scale e^(-n/b), after n generations.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

Array = np.ndarray
# A search has come to rest where the last quarter of its generations adds no more than this share of the hypervolume.
QUARTER, RESTING = 0.25, 0.02
# Generations from which on a search may be ended: before, a quarter of them is too few to go by.
FEWEST = 12
# Generations with a front that a curve is fitted to at least, and growth of a budget at most.
FITTED, MOST_TIMES = 5, 8
# Exponents a that are tried, and time constants b over the number of generations.
EXPONENTS, CONSTANTS = np.geomspace(0.25, 4.0, 25), np.geomspace(0.05, 2.0, 25)


class Budget(NamedTuple):
    """Generations of a search at most; converges: it ends before, where it has come to rest."""

    generations: int
    converges: bool = False

    def spent(self, volumes: Sequence[float]) -> bool:
        """Return whether a search ends that has come to these hypervolumes, one a generation."""
        return len(volumes) >= self.generations or (self.converges and has_converged(volumes))


class Curve(NamedTuple):
    """A hypervolume over generations, limit - scale remainder(n); error: sum of the squares that it leaves."""

    limit: float
    scale: float
    remainder: Callable[[Array], Array]
    error: float

    def at(self, generations: Array) -> Array:
        """Return the hypervolume after so many generations."""
        return self.limit - self.scale * self.remainder(generations)


def last_quarter(generations: int) -> int:
    """Return how many generations the last quarter of a search has."""
    return max(round(QUARTER * generations), 1)


def gained(volumes: Sequence[float]) -> float:
    """Return the share of the hypervolume, one a generation, that the last quarter of the search brought; 0 without a front."""
    if len(volumes) < 2 or volumes[-1] <= 0.0:
        return 0.0
    return (volumes[-1] - volumes[-1 - last_quarter(len(volumes))]) / volumes[-1]


def has_converged(volumes: Sequence[float]) -> bool:
    """Return whether a search with a front has come to rest, so that it may end."""
    return len(volumes) >= FEWEST and volumes[-1] > 0.0 and gained(volumes) <= RESTING


def generations_to_rest(volumes: Sequence[float]) -> int | None:
    """Return the number of generations after which the search would have come to rest.

    None where fewer than `FITTED` generations have a front, or where that takes more than `MOST_TIMES` as many generations.
    """
    curve = _fitted(np.asarray(volumes, dtype=float))
    if curve is None:
        return None
    for generations in range(len(volumes) + 1, MOST_TIMES * len(volumes) + 1):
        before, there = curve.at(np.array([generations - last_quarter(generations), generations], dtype=float))
        if there - before <= RESTING * there:
            return generations
    return None


def _fitted(volumes: Array) -> Curve | None:
    """Return the curve through the last three quarters of the generations with a front."""
    found = np.flatnonzero(volumes > 0.0)
    kept = found[len(found) // 4 :]
    if len(kept) < FITTED:
        return None
    shapes = [lambda n, a=a: n**-a for a in EXPONENTS]
    shapes += [lambda n, b=b: np.exp(-n / b) for b in CONSTANTS * len(volumes)]
    curves = [_through(kept + 1.0, volumes[kept], shape) for shape in shapes]
    # A front dominates at most the whole box.
    return min((curve for curve in curves if curve.limit <= 1.0), key=lambda curve: curve.error, default=None)


def _through(generations: Array, volumes: Array, remainder: Callable[[Array], Array]) -> Curve:
    """Return the curve of a shape that fits hypervolumes after so many generations best."""
    left = remainder(generations)
    apart = left - left.mean(axis=0)
    scale = -float((apart * volumes).sum(axis=0) / np.square(apart).sum(axis=0))
    limit = float(volumes.mean(axis=0) + scale * left.mean(axis=0))
    return Curve(limit, scale, remainder, float(np.square(volumes - limit + scale * left).sum(axis=0)))
