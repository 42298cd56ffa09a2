"""Worth of trying a point: the improvement of a front's hypervolume in the mean over samples, any number of objectives.

The hypervolume up to a reference is, but for a constant, the mean over directions of the m-th power of how far the front reaches
along each (D. Golovin, Q. Zhang, "Random hypervolume scalarizations for provable multi-objective black box optimization", ICML
2020, lemma 5). With one objective there is one direction, and the mean over samples is the expected improvement.
"""

from math import gamma, pi

import numpy as np

from tuner.search.covariance import compiled
from tuner.search.sobol import Sobol
from tuner.search.surrogate import Expectation

Array = np.ndarray
# Reach of the reference point beyond the default, in units of how far the front is ahead of it; and how far it is from the best
# values at least.
BEYOND, LEAST_EDGE = 0.1, 2.0


def directions(count: int, objectives: int, draw: np.random.Generator) -> Array:
    """Return directions (count, m) of the positive orthant, evenly spread, turned at random; a single one for m = 1."""
    if objectives == 1:
        return np.ones((1, 1))
    if objectives == 2:
        angle = (np.arange(count) + draw.uniform()) / count * (pi / 2.0)
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)
    from scipy.special import ndtri

    # The normal distribution has no direction of its own; of each number, the half above 0.
    share = Sobol(objectives, draw).random(count)
    normal = np.maximum(ndtri(0.5 + 0.5 * share), 1e-9)
    return normal / np.sqrt(np.square(normal).sum(axis=1, keepdims=True))


def share_of_ball(m: int) -> float:
    """Return what the mean over directions is to be multiplied by to be a hypervolume: the positive part of the unit ball's."""
    return pi ** (m / 2.0) / gamma(m / 2.0 + 1.0) / 2.0**m


def reached(ahead: Array, along: Array) -> Array:
    """Return how far points ahead (..., m) of a reference reach along directions (l, m), to the power m: (..., l)."""
    reach = np.min(ahead[..., None, :] / along, axis=-1)
    return np.maximum(reach, 0.0) ** along.shape[1]


@compiled
def improvements(samples: Array, along: Array, best: Array) -> Array:
    """Return what each of p points reaches beyond the best, in the mean over samples (s, p, m) and directions (l, m).

    best (s, l): what the front of each sample reaches.
    """
    found = np.zeros(samples.shape[1])
    inverse = 1.0 / along
    for s in range(samples.shape[0]):
        for p in range(samples.shape[1]):
            total = 0.0
            for i in range(len(along)):
                reach = samples[s, p, 0] * inverse[i, 0]
                for j in range(1, samples.shape[2]):
                    reach = min(reach, samples[s, p, j] * inverse[i, j])
                reach = max(reach, 0.0)
                power = reach
                for _ in range(1, samples.shape[2]):
                    power *= reach
                total += max(power - best[s, i], 0.0)
            found[p] += total
    return found / (samples.shape[0] * len(along))


class Box:
    """The part of the objectives in which a front is measured: from its smallest values to a reference point.

    front (k, m); default (m,), None where it failed. The reference is a tenth beyond the default, as that of the hypervolume that
    people are shown, or beyond the middle of the front where that does not come up to the default.
    """

    def __init__(self, front: Array, default: Array | None) -> None:
        self._low = front.min(axis=0)
        anchor = np.maximum(np.median(front, axis=0), front.max(axis=0) if default is None else default)
        self._edges = np.maximum((1.0 + BEYOND) * (anchor - self._low), LEAST_EDGE)

    def ahead(self, values: Array) -> Array:
        """Return how far values (..., m) are ahead of the reference, in edges of the box."""
        return 1.0 - (values - self._low) / self._edges


class Improvement:
    """Hypervolume that points add to a front and to those chosen before.

    samples (s, p, m), front (k, m): how far points are ahead of a reference in each objective; along (l, m): directions.
    """

    def __init__(self, samples: Array, front: Array, along: Array) -> None:
        self._samples, self._along = samples, along
        self._best = np.tile(reached(front, along).max(axis=0), (len(samples), 1))

    def of(self, rows: Array) -> Array:
        """Return the mean improvement by each of some points (r,)."""
        return improvements(np.ascontiguousarray(self._samples[:, rows]), self._along, self._best)

    def choose(self, row: int) -> None:
        """Count a point as tried: in each sample as what it is there."""
        self._best = np.maximum(self._best, reached(self._samples[:, row], self._along))


class Hope:
    """Merit of points while nobody knows one that keeps every limit: larger the less they may break, drawn anew each time."""

    def __init__(self, limits: list[Expectation], count: int, draw: np.random.Generator) -> None:
        self._limits, self._count, self._draw = limits, count, draw
        self.choose(0)

    def of(self, rows: Array) -> Array:
        """Return the hope put in some points (r,): 1 in one that breaks nothing."""
        return self._drawn[rows]

    def choose(self, _: int) -> None:
        """Draw anew."""
        broken = np.zeros(self._count)
        for limit in self._limits:
            broken += np.maximum(limit.mean + limit.deviation * self._draw.standard_normal(self._count), 0.0)
        self._drawn = np.exp(-broken)
