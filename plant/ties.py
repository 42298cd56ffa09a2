"""Ties: values that differ by rounding alone count as equal, and the first of them is named.

The same flights differ by 1e-15 between processors, which contract products and sums in another way. A decision between values
closer than 1e-10 is therefore made by their order, which is the same on every machine.
"""

import numpy as np
from numpy.typing import NDArray

TIE = 1e-10
"""Relative difference up to which two values are equal: 1e5 times the rounding of a flight's metrics."""


def first_smallest(values: NDArray[np.float64], scale: float = 0.0) -> int:
    """Return the index of the first of values (n,) that equal the smallest.

    scale: size of the terms that values are sums of, where these cancel.
    """
    smallest = float(values.min())
    if not np.isfinite(smallest):
        return int(np.argmin(values))
    return int(np.argmax(values <= smallest + TIE * max(abs(smallest), scale)))


def first_largest(values: NDArray[np.float64], scale: float = 0.0) -> int:
    """Return the index of the first of values (n,) that equal the largest; scale: see `first_smallest`."""
    return first_smallest(-values, scale)


def increasing_order(values: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the indices (n,) of values (n,) in increasing order.

    Equal ones keep their order.

    Values are equal to the smallest of a run of close ones, so an order never depends on how rounding split a run.
    """
    order = np.argsort(values, kind="stable")
    rank, start = np.zeros(len(values), dtype=int), 0
    for place in range(1, len(order)):
        first, value = values[order[start]], values[order[place]]
        # Infinite and missing values are equal to themselves alone.
        is_equal = value == first or (np.isfinite(first) and value - first <= TIE * abs(first))
        start = start if is_equal else place
        rank[order[place]] = start
    return np.argsort(rank, kind="stable")


def mean_ranks(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the ranks (n,) of finite values (n,), 1 for the smallest; equal values share their mean rank.

    SciPy has it too, but `scipy.stats` takes 0.7 s to import.
    """
    _, which, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - 0.5 * (count - 1))[which]
