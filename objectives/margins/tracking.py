"""Performance of a stable loop: tracking bandwidth and load rejection."""

import numpy as np
from numpy.typing import NDArray

from objectives.margins import curve
from objectives.margins.frequency import Modes

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Squared share of the reference at the bandwidth: -3 dB.
MIN_TRACKED_POWER = 0.5
# A larger steady error, as a share of its parts, is not due to rounding: the load is not rejected.
MAX_STEADY_SHARE = 1e-7
# Points that are enough to see a bandwidth, which narrow resonances get points of their own for.
POINTS = 50


def bandwidth(modes: Modes, residues: Complex, grid: Array, h: float) -> Array:
    """Return the bandwidth (n, k) [rad/s]; 0 for loops that are not stable.

    It is the highest frequency at which y follows r to within -3 dB.
    residues (n, k, b): from the reference of each of k channels to its output.
    """
    bandwidths = np.zeros(residues.shape[:2])
    thinned = np.ascontiguousarray(grid[:, :: grid.shape[1] // POINTS])
    curve.highest_crossings(thinned, modes.poles, residues, modes.stable, h, MIN_TRACKED_POWER, bandwidths)
    return bandwidths


def load_index(modes: Modes, residues: Complex, h: float) -> Array:
    """Return the load-disturbance index k_i (n, k) of k loops.

    k_i = 1/|integral of e dt| after a unit step of the load, in s^-3 for an acceleration.
    For a PID loop it is the integral gain (K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, section 4.3). 0 for loops
    that leave a steady error or are not stable. residues (n, k, b): from the load of each of k channels to its error.
    """
    distance = 1.0 - modes.poles[:, None, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        steady = residues / distance
        # With G(1) = 0 the sum of the errors after a step is G'(1).
        integral = h * np.abs(np.sum(steady / distance, axis=-1))
        rejected = np.abs(np.sum(steady, axis=-1)) < MAX_STEADY_SHARE * np.sum(np.abs(steady), axis=-1)
        index = 1.0 / integral
    return np.where(modes.stable[:, None] & rejected & np.isfinite(index), index, 0.0)
