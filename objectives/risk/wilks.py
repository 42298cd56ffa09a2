"""Bounds of a quantile from order statistics, for any distribution.

Of n independent values those beyond the quantile at level a are binomial: at least as many as of n draws of probability 1 - a.
So the k-th largest is at least the quantile with the probability that these are k or more (S. S. Wilks, "Determination of
sample sizes for setting tolerance limits", Annals of Mathematical Statistics 12(1):91-96, 1941). Of flights of several scenarios
they are spread no wider than binomial ones (W. Hoeffding, Annals of Mathematical Statistics 27(3):713-721, 1956).
"""

from math import ceil, log

import numpy as np

from objectives.risk.measures import ROUNDING


def flights_to_bound(level: float, confidence: float = 0.95) -> int:
    """Return the number of flights whose largest value bounds a quantile."""
    return ceil(log(1.0 - confidence) / log(level) - ROUNDING)


def bound_rank(count: int, level: float, confidence: float = 0.95) -> int | None:
    """Return the largest k whose k-th largest value bounds a quantile.

    None where the largest of `count` values does not.
    """
    # SciPy takes 0.2 s to import.
    from scipy.special import bdtrc  # pyright: ignore[reportMissingTypeStubs]

    # bdtrc(k - 1, n, p) is the probability of k or more.
    return int(np.count_nonzero(bdtrc(np.arange(count), count, 1.0 - level) >= confidence)) or None
