"""Estimate of a point by its difference to another one.

The other one made more of the same flights. Points that lie close together rise and fall with the air alike, so their difference
varies far less than their values (control variates: P. Glasserman, "Monte Carlo Methods in Financial Engineering", Springer,
2003, section 4.1). One point at a limit that flies on decides the limit of its neighbors, too.
"""

from typing import NamedTuple

import numpy as np

from objectives.risk import PairedDifference
from tuner.analysis.final_flights import carried


class Paired(NamedTuple):
    """Estimate of a point by another one.

    Attributes:
        estimate: Value, lower and upper end (3,).
        above: Distance from the value to the upper end of the point's own flights.
        is_led: Whether more flights of the other point narrow the interval more than those of the point itself.
    """

    estimate: np.ndarray
    above: float
    is_led: bool


def paired_estimate(alone: np.ndarray, other: np.ndarray, difference: PairedDifference) -> Paired | None:
    """Return the estimate by a paired difference, if it is narrower.

    alone, other (3,): value, lower and upper end of the point and of the other one, by the flights of each alone.
    """
    estimate = np.array(carried((other[0], other[1], other[2]), difference))
    if estimate[2] - estimate[1] >= alone[2] - alone[1]:
        return None
    return Paired(estimate, float(alone[2] - alone[0]), bool(difference.high - difference.low < other[2] - other[1]))
