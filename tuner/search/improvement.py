"""Expected improvement of a front's hypervolume, in any number of objectives, by common samples.

The hypervolume up to a reference is, but for a constant, the mean over directions of the m-th power of how far the front reaches
along each (D. Golovin, Q. Zhang, "Random hypervolume scalarizations for provable multi-objective black box optimization", ICML
2020, lemma 5). With one objective there is one direction, and the mean over samples is the expected improvement.
"""

from math import pi

import numpy as np

from tuner.search.covariance import Array, compiled


def directions(count: int, objectives: int, draw: np.random.Generator) -> Array:
    """Return directions (count, m) of the positive orthant, evenly spread, turned at random; a single one for m = 1."""
    if objectives == 1:
        return np.ones((1, 1))
    if objectives == 2:
        angle = (np.arange(count) + draw.uniform()) / count * (pi / 2.0)
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)
    from scipy.special import ndtri
    from scipy.stats.qmc import Sobol

    # Half the normal distribution, which has no direction of its own: numbers above one half.
    normal = ndtri(0.5 + 0.5 * Sobol(objectives, scramble=True, rng=draw).random(count))
    normal = np.maximum(normal, 1e-9)
    return normal / np.sqrt(np.square(normal).sum(axis=1, keepdims=True))


@compiled
def reached(values: Array, directions: Array, best: Array) -> None:
    """Raise best (l,) to how far one of values (n, m) reaches along each of directions (l, m), to the power m.

    values: how much better than the reference each is, in each objective.
    """
    for row in values:
        for i in range(len(directions)):
            reach = np.inf
            for j in range(len(row)):
                reach = min(reach, row[j] / directions[i, j])
            best[i] = max(best[i], max(reach, 0.0) ** len(row))


@compiled
def improvements(samples: Array, directions: Array, best: Array) -> Array:
    """Return the mean improvement (p,) of each of p candidates over the samples (s, p, m).

    directions (l, m); best (s, l): what the front of each sample reaches, see `reached`.
    """
    found = np.zeros(samples.shape[1])
    inverse = 1.0 / directions
    for s in range(samples.shape[0]):
        for p in range(samples.shape[1]):
            total = 0.0
            for i in range(len(directions)):
                reach = samples[s, p, 0] * inverse[i, 0]
                for j in range(1, samples.shape[2]):
                    reach = min(reach, samples[s, p, j] * inverse[i, j])
                power = max(reach, 0.0)
                for _ in range(1, samples.shape[2]):
                    power *= max(reach, 0.0)
                total += max(power - best[s, i], 0.0)
            found[p] += total
    return found / (samples.shape[0] * len(directions))


def hypervolume_share(m: int) -> float:
    """Return what the mean of `improvements` is to be multiplied by to be a hypervolume: the orthant's share of a ball."""
    from math import gamma

    return pi ** (m / 2.0) / gamma(m / 2.0 + 1.0) / 2.0**m
