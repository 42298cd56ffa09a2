"""Intervals of risks on resamples that a generator draws."""

import numpy as np
from numpy.typing import NDArray

from objectives.risk import Interval, PairedDifference, Risk, interval_on, paired_difference_on


def bootstrap_interval(
    values: NDArray[np.float64], risk: Risk, rng: np.random.Generator, replicates: int = 2000, confidence: float = 0.95
) -> Interval:
    """Return the interval of the risk of values (..., n)."""
    n = values.shape[-1]
    return interval_on(values, risk, rng.integers(n, size=(replicates, n), dtype=np.intp), confidence)


def paired_difference(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    risk: Risk,
    rng: np.random.Generator,
    replicates: int = 2000,
) -> PairedDifference:
    """Return risk(first) - risk(second) with its interval; both (..., n) flew through the same n scenarios."""
    n = first.shape[-1]
    return paired_difference_on(first, second, risk, rng.integers(n, size=(replicates, n), dtype=np.intp))
