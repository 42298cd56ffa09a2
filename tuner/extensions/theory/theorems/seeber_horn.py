"""Seeber and Horn's region of super-twisting gains: simple, and wide enough for the usual 1.5 L^(1/2), 1.1 L.

    k2 > L,   k1 > (k2 + L)^(1/2)

R. Seeber, M. Horn, "Stability proof for a well-established super-twisting parameter setting", Automatica 84:241-243, 2017.
Note that k1 must grow with k2: at a given k1 the best k2 is k1^2/2, which bears L = k1^2/2.
"""

import numpy as np

from tuner.extensions.theory.theorems.theorem import Array
from tuner.extensions.theory.theorems.twisting_conditions import condition


def seeber_horn_rate(k1: Array, k2: Array) -> Array:
    """Return the largest rate borne [y/s3]."""
    return np.maximum(np.minimum(k2, k1**2 - k2), 0.0)


SEEBER_HORN = condition(
    "sta_seeber_horn", "Seeber and Horn's gain condition", "Seeber, Horn, Automatica 84:241-243, 2017", seeber_horn_rate
)
