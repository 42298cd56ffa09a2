"""The first generation: the given starting points, then a Latin hypercube.

M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21(2):239-245, 1979: each variable takes every stratum once. Points that
are not worth a flight give way to points of further hypercubes that are: asking costs little, and a search that starts from a
handful of feasible points stays near them.
"""

from collections.abc import Callable

import numpy as np

# Hypercubes drawn at most in place of points that are not worth a flight: enough where 3 % are, for a second or two.
FURTHER = 48
# Hypercubes that are asked about together: one after the other takes longer.
TOGETHER = 6


def latin_hypercube(count: int, dimensions: int, draw: np.random.Generator) -> np.ndarray:
    """Return points (count, dimensions) of the unit cube, one in each of `count` strata of every dimension."""
    strata = np.stack([draw.permutation(count) for _ in range(dimensions)], axis=1)
    return (strata + draw.uniform(size=(count, dimensions))) / count


def first_generation(
    starts: np.ndarray,
    count: int,
    draw: np.random.Generator,
    worthy: Callable[[np.ndarray], np.ndarray] | None = None,
) -> np.ndarray:
    """Return `count` points (count, d): the starting points (k, d), then a Latin hypercube of the rest.

    worthy: points (n, d) -> mask (n,) of those worth a flight; None for all.
    """
    points = latin_hypercube(count - len(starts), starts.shape[1], draw)
    if worthy is not None:
        points = _replaced(points, draw, worthy)
    return np.concatenate([starts, points], axis=0)


def _replaced(points: np.ndarray, draw: np.random.Generator, worthy: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Replace points (n, d) that are not worth a flight as far as worthy ones are found."""
    points, open_rows = points.copy(), np.flatnonzero(~worthy(points))
    for _ in range(FURTHER // TOGETHER):
        if not len(open_rows):
            break
        further = np.concatenate([latin_hypercube(len(points), points.shape[1], draw) for _ in range(TOGETHER)])
        found = further[worthy(further)][: len(open_rows)]
        points[open_rows[: len(found)]] = found
        open_rows = open_rows[len(found) :]
    return points
