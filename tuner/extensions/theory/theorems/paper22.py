"""The gain condition that the paper quotes for super-twisting; sufficient, though its hybrid law is none.

    k2 > L,   k1^2 > 2 (k2 + L)

Wu et al., Appl. Sci. 2025, 15(9), 5124, equation (22), whose bar over d must be read as a bound on the rate of the disturbance,
not on the disturbance. Its extracted text has lost the brackets; 2 k2 + L would do as well, for both imply Seeber and Horn's
k1^2 > k2 + L, and this is the one that holds under either reading.
"""

import numpy as np

from tuner.extensions.theory.theorems.theorem import Array
from tuner.extensions.theory.theorems.twisting_conditions import condition


def paper22_rate(k1: Array, k2: Array) -> Array:
    """Return the largest rate borne [y/s3]."""
    return np.maximum(np.minimum(k2, 0.5 * k1**2 - k2), 0.0)


PAPER22 = condition(
    "sta_paper22", "the paper's gain condition (22)", "Wu et al., Appl. Sci. 2025, 15(9), 5124, (22)", paper22_rate
)
