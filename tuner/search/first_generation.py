"""The first generation: the given starting points, then a Latin hypercube.

M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21(2):239-245, 1979: each variable takes every stratum once.
"""

import numpy as np


def latin_hypercube(count: int, dimensions: int, draw: np.random.Generator) -> np.ndarray:
    """Return points (count, dimensions) of the unit cube, one in each of `count` strata of every dimension."""
    strata = np.stack([draw.permutation(count) for _ in range(dimensions)], axis=1)
    return (strata + draw.uniform(size=(count, dimensions))) / count


def first_generation(starts: np.ndarray, count: int, draw: np.random.Generator) -> np.ndarray:
    """Return `count` points (count, d): the starting points (k, d), then a Latin hypercube of the rest."""
    return np.concatenate([starts, latin_hypercube(count - len(starts), starts.shape[1], draw)], axis=0)
