"""The fastest disturbance that super-twisting gains bear at all: sufficient and necessary, from the worst disturbance itself.

The worst |d'| <= L pushes along S' all the time, d' = L sgn S'. No other trajectory from the same point stays outside that one,
the majorant curve of A. Levant, Int. J. Control 58(6), 1993. Half a turn takes it from S = 0, S' = 1 to S = 0, S' = -r, so the
gains bear L exactly where r < 1. With y = |S|^(1/2) and a time that runs 2 y times slower both quarters are linear,

    S' > 0:  y'' + k1 y' + 2 (k2 - L) y = 0,     S' < 0:  y'' + k1 y' + 2 (k2 + L) y = 0

which gives r = ((k2 + L)/(k2 - L))^(1/2) exp(-(k1/2)(t1 + t2)), t1 being the time from y = 0 to its peak in the first and t2
that from the peak to 0 in the second, infinite where it does not swing. Worked out here; use it to see how much the simpler
conditions give away. r grows with L, so L is found by bisection.
"""

import numpy as np

from tuner.extensions.theory.theorems.theorem import Array
from tuner.extensions.theory.theorems.twisting_conditions import condition

# Halvings of the interval (0, k2), to a few roundings; the middle must stay below k2.
HALVINGS = 50


def rise_time(k1: Array, stiffness: Array) -> Array:
    """Return t1: from y = 0 to the peak of y'' + k1 y' + stiffness y = 0, stiffness above 0."""
    square = stiffness - 0.25 * k1**2
    w = np.maximum(np.sqrt(np.abs(square)), 1e-9 * np.sqrt(stiffness))
    return np.where(square > 0.0, np.arctan2(2.0 * w, k1), np.log((0.5 * k1 + w) / np.sqrt(stiffness))) / w


def fall_time(k1: Array, stiffness: Array) -> Array:
    """Return t2: from the peak to y = 0; infinite where y creeps to 0."""
    square = stiffness - 0.25 * k1**2
    w = np.sqrt(np.maximum(square, 0.0))
    with np.errstate(divide="ignore"):
        return np.where(square > 0.0, (np.pi - np.arctan2(2.0 * w, k1)) / w, np.inf)


def log_contraction(k1: Array, k2: Array, rate: Array) -> Array:
    """Return ln r for a rate [y/s3] below k2; the gains bear the rate where it is negative."""
    slow, fast = 2.0 * (k2 - rate), 2.0 * (k2 + rate)
    return 0.5 * np.log(fast / slow) - 0.5 * k1 * (rise_time(k1, slow) + fall_time(k1, fast))


def worst_case_rate(k1: Array, k2: Array) -> Array:
    """Return the largest rate borne [y/s3]; 0 for gains of which one is 0."""
    k1, k2 = np.broadcast_arrays(k1, k2)
    active = (k1 > 0.0) & (k2 > 0.0)
    # In units of k2, which leaves k1/k2^(1/2).
    scaled, unit = np.where(active, k1, 1.0) / np.sqrt(np.where(active, k2, 1.0)), np.ones(k2.shape)
    low, high = np.zeros(k2.shape), np.ones(k2.shape)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        borne = log_contraction(scaled, unit, middle) < 0.0
        low, high = np.where(borne, middle, low), np.where(borne, high, middle)
    return np.where(active, low * k2, 0.0)


WORST_CASE = condition(
    "sta_worst_case",
    "the worst disturbance itself",
    "Levant, Int. J. Control 58(6), 1993, majorant curve; closed form worked out here",
    worst_case_rate,
)
