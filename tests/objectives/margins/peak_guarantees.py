"""Peaks of the sensitivity functions and what they guarantee.

Ms = max |1/(1 + L)| is the inverse of the modulus margin, the distance of L from -1; Mt = max |L/(1 + L)|. K. J. Astrom,
R. M. Murray, Feedback Systems, 2nd ed., Princeton 2021, sections 12.2 and 13.2: values of Ms from 1.2 to 2.0 are reasonable.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class PeakGuarantee(NamedTuple):
    """Least factor by which the gain may rise [1] and least phase margin [rad] that a peak leaves room for."""

    gain: Array
    phase: Array


def guaranteed_by_sensitivity(peak: Array) -> PeakGuarantee:
    """Gain margin >= Ms/(Ms - 1), phase margin >= 2 asin(1/(2 Ms)); nothing, 1 and 0, for an infinite peak."""
    distance = 1.0 / np.asarray(peak, dtype=float)
    with np.errstate(divide="ignore"):
        return PeakGuarantee(1.0 / (1.0 - distance), 2.0 * np.arcsin(0.5 * distance))


def guaranteed_by_complementary(peak: Array) -> PeakGuarantee:
    """Gain margin >= 1 + 1/Mt, phase margin >= 2 asin(1/(2 Mt)); a peak below 1/2 leaves every phase, pi."""
    with np.errstate(divide="ignore"):
        distance = 1.0 / np.asarray(peak, dtype=float)
    return PeakGuarantee(1.0 + distance, 2.0 * np.arcsin(np.minimum(0.5 * distance, 1.0)))
