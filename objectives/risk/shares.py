"""Exact intervals of shares: how often a quantity that is 0 or 1 by definition is 1.

A bootstrap of flights that all ended well ends well too: it puts [0, 0] around a share that was merely not seen. Sources:

- The interval of a share: C. J. Clopper, E. S. Pearson, "The use of confidence or fiducial limits illustrated in the case of the
  binomial", Biometrika 26(4):404-413, 1934. It never covers less than it promises. Flights of several scenarios have a share
  each; their sum is spread no wider than a binomial one: W. Hoeffding, "On the distribution of the number of successes in
  independent trials", Annals of Mathematical Statistics 27(3):713-721, 1956.
- The difference of two shares on the same flights: only flights that end differently tell of it (Q. McNemar, "Note on the
  sampling error of the difference between correlated proportions or percentages", Psychometrika 12(2):153-157, 1947). With q the
  share of them and w how many of them are the first's, it is q (2 w - 1). Given how many there are, their split is binomial, so
  two Clopper-Pearson intervals, each at the root of the confidence, hold q and w together at the confidence.

Every risk of such a quantity is an increasing function of the share, which carries its ends over.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from objectives.risk.measures import Interval, Risk

Values = NDArray[np.float64]
Counts = NDArray[np.int64] | int


def clopper_pearson(events: Counts, count: Counts, confidence: float = 0.95) -> Interval:
    """Return the two-sided interval of the share `events` (...) of `count` (...); [0, 1] of none."""
    # SciPy takes 0.2 s to import, and not every command has shares.
    from scipy.special import betaincinv  # pyright: ignore[reportMissingTypeStubs]

    k, n = np.broadcast_arrays(np.asarray(events, dtype=float), np.asarray(count, dtype=float))
    tail = 0.5 * (1.0 - confidence)
    low = np.where(k > 0.0, betaincinv(np.maximum(k, 1.0), n - k + 1.0, tail), 0.0)
    high = np.where(k < n, betaincinv(k + 1.0, np.maximum(n - k, 1.0), 1.0 - tail), 1.0)
    return Interval(low, high)


def upper_bound(events: int, count: int, confidence: float = 0.95) -> float:
    """Return the one-sided upper bound of a share; of 0 of n it is 1 - (1 - confidence)^(1/n), about 3/n at 0.95."""
    return float(clopper_pearson(events, count, 2.0 * confidence - 1.0).high)


def flights_to_show(limit: float, confidence: float = 0.95) -> int:
    """Return the number of event-free flights whose interval is within a limit.

    limit: above 0.
    """
    return int(np.ceil(np.log(0.5 * (1.0 - confidence)) / np.log1p(-limit) - 1e-9)) if limit < 1.0 else 1


def binary_interval(values: Values, risk: Risk, confidence: float = 0.95) -> Interval:
    """Return the interval of the risk of binary values (..., n)."""
    ends = clopper_pearson(_events(values), values.shape[-1], confidence)
    return Interval(*(risk_of_share(end, risk) for end in ends))


def binary_difference(first: Values, second: Values, risk: Risk, confidence: float = 0.95) -> Interval:
    """Return the interval of risk(first) - risk(second) of paired binary values (..., n)."""
    first, second = np.broadcast_arrays(first, second)
    if risk.is_mean:
        return share_difference(
            _events(first - second > 0.0), _events(second - first > 0.0), first.shape[-1], confidence
        )
    # Any other risk is no linear function of the share: Bonferroni.
    mine, other = (binary_interval(values, risk, 0.5 * (1.0 + confidence)) for values in (first, second))
    return Interval(mine.low - other.high, mine.high - other.low)


def share_difference(first: Counts, second: Counts, count: Counts, confidence: float = 0.95) -> Interval:
    """Return the interval of a difference of shares from discordant flights.

    first, second: discordant flights of either (...).
    """
    different = np.asarray(first) + np.asarray(second)
    often = clopper_pearson(different, count, sqrt(confidence))
    mine = clopper_pearson(first, different, sqrt(confidence))
    low, high = 2.0 * mine.low - 1.0, 2.0 * mine.high - 1.0
    return Interval(
        low * np.where(low < 0.0, often.high, often.low), high * np.where(high > 0.0, often.high, often.low)
    )


def risk_of_share(share: Values, risk: Risk) -> Values:
    """Return the risk (...) of a Bernoulli variable of probability `share` (...)."""
    if risk.is_mean:
        return share
    if risk.name == "cvar":
        return np.minimum(share / (1.0 - (risk.level or 0.0)), 1.0)
    return (share > (1.0 - (risk.level or 0.0) if risk.name == "quantile" else 0.0)).astype(float)


def _events(values: Values | NDArray[np.bool_]) -> NDArray[np.int64]:
    return np.count_nonzero(values, axis=-1)
