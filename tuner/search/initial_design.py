"""The initial design: the given starting points, then a Latin hypercube.

M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21(2):239-245, 1979: each variable takes every stratum once. Points that
fail pre-screening are replaced by points of further hypercubes that pass: screening costs little, and a search that starts from a
handful of feasible points stays near them.
"""

from collections.abc import Callable

import numpy as np

from tuner.search.feasible_points import evolve_feasible_points

# Largest number of hypercubes sampled to replace points: enough where 3 % pass pre-screening, for a second or two.
MAX_EXTRA_HYPERCUBES = 48
# Hypercubes that are screened at once: one after the other takes longer.
HYPERCUBE_BATCH = 6
# Least number of points screened at once where the first passing ones are wanted: a batch takes as long as some ten points of it.
SCREENING_BATCH = 24


def latin_hypercube(count: int, dimensions: int, rng: np.random.Generator) -> np.ndarray:
    """Return points (count, dimensions): one in each of `count` strata of every dimension of the unit cube."""
    strata = np.stack([rng.permutation(count) for _ in range(dimensions)], axis=1)
    return (strata + rng.uniform(size=(count, dimensions))) / count


def initial_design(
    starts: np.ndarray,
    count: int,
    rng: np.random.Generator,
    excess: Callable[[np.ndarray], np.ndarray] | None = None,
    spare: np.ndarray | None = None,
) -> np.ndarray:
    """Return `count` points (count, d): the starting points (k, d), then a Latin hypercube of the rest.

    Points of it beyond a limit give way: to samples of further hypercubes; then to spare points, or where there are none and
    nothing sampled passes, to points that evolve from the samples.

    Args:
        starts: Starting points (k, d).
        count: Number of points.
        rng: Source of the hypercubes.
        excess: Points (n, d) -> excess (n, h) over limits that are known without flying, 0 or less where a point is worth a
            flight; None where all are.
        spare: Further starting points (s, d). With them few hypercubes are sampled: feasible points are at hand.
    """
    points = latin_hypercube(count - len(starts), starts.shape[1], rng)
    if excess is None or not len(points):
        return np.concatenate([starts, points])

    def passes(candidates: np.ndarray) -> np.ndarray:
        return np.all(excess(candidates) <= 0.0, axis=1)

    spare = starts[:0] if spare is None else spare
    hypercubes = HYPERCUBE_BATCH if len(spare) else MAX_EXTRA_HYPERCUBES
    points, failing, samples = _replace_failing(points, rng, passes, hypercubes)
    if len(spare):
        others = first_passing(spare, len(failing), passes)
    elif len(failing) == len(points):
        others = evolve_feasible_points(samples, excess, len(points), rng)
    else:
        others = points[:0]
    points[failing[: len(others)]] = others
    return np.concatenate([starts, points])


def first_passing(
    points: np.ndarray, count: int, passes_screening: Callable[[np.ndarray], np.ndarray], share: float = 1.0
) -> np.ndarray:
    """Return the first `count` of points (n, d) that pass screening; few more are screened than needed.

    share: expected share of passing points, which says how many are screened at once.
    """
    passing, first = points[:0], 0
    while first < len(points) and len(passing) < count:
        size = max((count - len(passing)) / share, SCREENING_BATCH) if share > 0.0 else len(points)
        batch = points[first : first + int(min(size, len(points)))]
        passing = np.concatenate([passing, batch[passes_screening(batch)]])
        first += len(batch)
    return passing[:count]


def _replace_failing(
    points: np.ndarray, rng: np.random.Generator, passes: Callable[[np.ndarray], np.ndarray], hypercubes: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points (n, d), failing ones replaced by passing samples.

    And the rows that fail still, and all samples (k, d).
    """
    drawn, points = [points], points.copy()
    open_rows = np.flatnonzero(~passes(points))
    share = 1.0 - len(open_rows) / len(points)
    for _ in range(hypercubes // HYPERCUBE_BATCH):
        if not len(open_rows):
            break
        samples = np.concatenate([latin_hypercube(len(points), points.shape[1], rng) for _ in range(HYPERCUBE_BATCH)])
        passing = first_passing(samples, len(open_rows), passes, share)
        points[open_rows[: len(passing)]] = passing
        open_rows = open_rows[len(passing) :]
        drawn.append(samples)
    return points, open_rows, np.concatenate(drawn)
