"""Compiled loops over the samples of a log: rotors that lag, and filters.

Without `fastmath`: every operation rounds by itself, in the order of the source.
"""

import math
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plant.backends.cache import keep_file
from plant.backends.compiling import kernel

Array = NDArray[np.float64]


def lag_windows(commands: Array, delay: float, before: int, width: int, rise: float, fall: float) -> Array:
    """Return delayed commands (n, 4) behind lags, in windows that are each run in.

    Args:
        commands: Commands (n, 4), held at both ends.
        delay: Delay in samples, between which commands are linearly interpolated.
        before: Number of samples that a window is run in over.
        width: Number of samples of a window.
        rise: Share of a gap that a sample closes upwards.
        fall: Share of a gap that a sample closes downwards.
    """
    n, n_samples = len(commands), math.floor(delay)
    share = delay - n_samples
    late, lagged, state = np.empty((n, 4)), np.empty((n, 4)), np.empty(4)
    for k in range(n):
        at, earlier = min(max(k - n_samples, 0), n - 1), min(max(k - n_samples - 1, 0), n - 1)
        for i in range(4):
            late[k, i] = (1.0 - share) * commands[at, i] + share * commands[earlier, i]
    for first in range(0, n, width):
        begin = max(first - before, 0)
        # Element by element: numba takes 2 s to compile the copy of a row.
        for i in range(4):
            state[i] = late[begin, i]
        for k in range(begin, min(first + width, n)):
            for i in range(4):
                if k >= first:
                    lagged[k, i] = state[i]
                gap = late[k, i] - state[i]
                state[i] += gap * (rise if gap > 0.0 else fall)
    return lagged


def filter_columns(numerator: Array, denominator: Array, columns: Array) -> Array:
    """Return columns (n, c) behind a filter of second order, from rest.

    Args:
        numerator: Coefficients (3,) in powers of the delay.
        denominator: Coefficients (3,), the first of them 1.
        columns: Series (n, c).
    """
    b0, b1, b2 = numerator
    _, a1, a2 = denominator
    n, count = columns.shape
    filtered, first, second = np.empty((n, count)), np.zeros(count), np.zeros(count)
    for k in range(n):
        for i in range(count):
            x = columns[k, i]
            y = first[i] + b0 * x
            first[i] = second[i] + x * b1 - y * a1
            second[i] = x * b2 - y * a2
            filtered[k, i] = y
    return filtered


lag_windows = keep_file(kernel({})(lag_windows), Path(__file__))
filter_columns = keep_file(kernel({})(filter_columns), Path(__file__))


def filtered(numerator: ArrayLike, denominator: ArrayLike, series: Array) -> Array:
    """Return a series (n, ...) behind a filter along its first axis, from rest.

    Args:
        numerator: Coefficients (3,) in powers of the delay; fewer where the others are 0.
        denominator: Coefficients (3,), the first of them 1; fewer where the others are 0.
        series: Series (n, ...).
    """
    coefficients = np.zeros((2, 3))
    for row, given in zip(coefficients, (numerator, denominator), strict=True):
        row[: np.size(given)] = given
    columns = np.ascontiguousarray(series).reshape(len(series), -1)
    return filter_columns(coefficients[0], coefficients[1], columns).reshape(series.shape)
