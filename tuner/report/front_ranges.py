"""Which part of an objective's axis a figure of the front shows: default, tuned and the held-out front, with intervals.

Search candidates, and finalists that failed when held out, may lie decades away (a failed flight costs more than any
completed one), so they do not count.
"""

from typing import NamedTuple

import numpy as np

from tuner.documents.results import Front

PADDING = 0.07
# Where the shown values span more than this factor, a linear axis would press most points into a corner.
LOG_FACTOR = 20.0


class Range(NamedTuple):
    """What an axis shows, in the objective's unit."""

    low: float
    high: float
    log: bool


def shown_range(front: Front, objective: int) -> Range:
    """Return the range of one objective."""
    rows = front.non_dominated | np.array([role != "" for role in front.roles])
    values = np.concatenate([column[rows, objective] for column in (front.held_out, front.low, front.high)])
    values = values[np.isfinite(values)]
    if len(values) == 0:
        return Range(0.0, 1.0, False)
    low, high = float(values.min()), float(values.max())
    if low > 0.0 and high > LOG_FACTOR * low:
        stretch = (high / low) ** PADDING
        return Range(low / stretch, high * stretch, True)
    margin = PADDING * (high - low) or 0.1 * abs(high) or 1.0
    return Range(low - margin, high + margin, False)
