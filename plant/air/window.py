"""Gating window of a disturbance: 0 outside (start, end), 1 inside, with raised-cosine edges of 0.25 s within it.

The edges keep the gated wind differentiable: a hard gate would add an acceleration step of its own to every scenario.
They lie inside the window, so nothing is left after `end` and recovery can be timed from there.
"""

from math import pi

import numpy as np
from numpy.typing import NDArray

EDGE = 0.25  # s


def gate(time: NDArray[np.float64], window: tuple[float, float] | None) -> NDArray[np.float64]:
    """Return the factor (K,) in [0, 1] at the times (K,) [s]; None is the whole run: 1 everywhere, without edges."""
    if window is None:
        return np.ones_like(time)
    start, end = window
    return _rise(time - start) * _rise(end - time)


def _rise(since: NDArray[np.float64]) -> NDArray[np.float64]:
    return 0.5 - 0.5 * np.cos(pi * np.clip(since / EDGE, 0.0, 1.0))
