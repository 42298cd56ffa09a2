"""Levant's region of super-twisting gains, the first proved and most cautious.

    k2 > L,   k1^2 >= 4 L (k2 + L)/(k2 - L)

A. Levant, "Sliding order and sliding accuracy in sliding mode control", Int. J. Control 58(6), 1993, and "Robust exact
differentiation via sliding mode technique", Automatica 34(3), 1998, here for an input gain that is known. The second
condition is 4 L^2 + (4 k2 + k1^2) L <= k1^2 k2, and its root is always below k2.
"""

import numpy as np

from tuner.extensions.theory.theorems.theorem import Array
from tuner.extensions.theory.theorems.twisting_conditions import condition


def levant_rate(k1: Array, k2: Array) -> Array:
    """Return the largest rate borne [y/s3]."""
    linear, constant = 4.0 * k2 + k1**2, k1**2 * k2
    return 2.0 * constant / np.maximum(linear + np.sqrt(linear**2 + 16.0 * constant), np.finfo(np.float64).tiny)


LEVANT = condition(
    "sta_levant",
    "Levant's gain condition",
    "Levant, Int. J. Control 58(6), 1993; Automatica 34(3), 1998",
    levant_rate,
)
