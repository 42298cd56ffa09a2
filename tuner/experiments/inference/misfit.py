"""Misfit of a setting to the published cells: one number for each kind of cell, 0 where all are met.

    r = ln(ours / published),    misfit of a kind = sqrt(mean over its cells of r^2),    kinds: "peak", "settling", ...

ours is the median over the flights. A published cell is one draw of the turbulence, and what one draw typically gives is the
median: it is the same before and after the logarithm, and neither the long tail of a peak, nor a settling time cut off by
the end of the flight, nor the cost of a failed flight moves it, as they move the mean. The logarithm counts twice too
large as much as half as large, and makes radians and seconds comparable.

Cells are not weighted by their scatter: a setting under which everything scatters would then fit best. What scatter is
for is the tolerance: how far one draw may fall from the median of its own distribution.
"""

import numpy as np

from tuner.experiments.contest.published import INSIDE
from tuner.study.inference import LEAST_RATIO

# Ends of the central 68 % and 95 % of flights.
CENTRAL_68, CENTRAL_95 = (0.16, 0.84), (0.025, 0.975)


def log_ratio(ours: np.ndarray, published: np.ndarray) -> np.ndarray:
    """Return ln(ours / published) (...), where no ratio counts for less than 1/50; published is positive."""
    return np.log(np.maximum(ours / published, LEAST_RATIO))


def misfits(medians: np.ndarray, published: np.ndarray, kinds: np.ndarray) -> np.ndarray:
    """Return the misfit of each kind (n, kinds) of medians (n, cells); kinds (cells,): number of each cell's kind."""
    squares = np.square(log_ratio(medians, published))
    return np.stack([np.sqrt(squares[:, kinds == kind].mean(axis=1)) for kind in range(int(kinds.max()) + 1)], axis=1)


def overall(misfits: np.ndarray) -> np.ndarray:
    """Return the root mean square over the kinds (n,) of misfits (n, kinds): all kinds count alike."""
    return np.sqrt(np.square(misfits).mean(axis=1))


def weights(kinds: np.ndarray) -> np.ndarray:
    """Return what the square of each log ratio counts (cells,) in the square of the misfit over all kinds; the sum is 1."""
    counts = np.bincount(kinds)
    return 1.0 / (len(counts) * counts[kinds])


def tolerance(scores: np.ndarray, published: np.ndarray) -> np.ndarray:
    """Return half the width of the central 68 % of ln(ours) over the flights (cells,), of scores (cells, flights)."""
    low, high = np.quantile(log_ratio(scores, published[:, None]), CENTRAL_68, axis=1)
    return 0.5 * (high - low)


def central(scores: np.ndarray) -> np.ndarray:
    """Return the ends of the central 95 % of the flights (2, ...), of scores (..., flights)."""
    return np.quantile(scores, CENTRAL_95, axis=-1)


def percentile(scores: np.ndarray, published: np.ndarray) -> np.ndarray:
    """Return the share of flights below the published value (..., cells), in per cent; half of those equal to it count.

    scores (..., cells, flights); published (cells,).
    """
    below = (scores < published[:, None]).mean(axis=-1)
    equal = (scores == published[:, None]).mean(axis=-1)
    return 100.0 * (below + 0.5 * equal)


def is_inside(percentiles: np.ndarray) -> np.ndarray:
    """Return whether one flight could well have given what was published: whether it is in the central 95 %."""
    return (percentiles >= INSIDE[0]) & (percentiles <= INSIDE[1])
