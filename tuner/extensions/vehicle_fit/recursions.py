"""Compiled loops over the samples of a log: rotors that lag.

Without `fastmath`: every operation rounds by itself, in the order of the source.
"""

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

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


lag_windows = keep_file(kernel({})(lag_windows), Path(__file__))
