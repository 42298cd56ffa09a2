"""Exact intervals of shares: how often a quantity that is 0 or 1 by definition is 1.

A bootstrap of flights that all ended well ends well too: it puts [0, 0] around a share that was merely not seen. Sources:

- The interval of a share: C. J. Clopper, E. S. Pearson, "The use of confidence or fiducial limits illustrated in the case of the
  binomial", Biometrika 26(4):404-413, 1934. It never covers less than it promises. Flights of several scenarios have a share
  each; their sum is spread no wider than a binomial one: W. Hoeffding, "On the distribution of the number of successes in
  independent trials", Annals of Mathematical Statistics 27(3):713-721, 1956.
- The difference of two shares on the same flights: only flights that end differently tell of it (Q. McNemar, "Note on the
  sampling error of the difference between correlated proportions or percentages", Psychometrika 12(2):153-157, 1947). With q the
  share of them and w how many of them are the first's, it is q (2 w - 1). Given how many there are, their split is binomial and
  independent of their number, so the distances of q and w to their ends join as variances do (MOVER: G. Y. Zou, A. Donner,
  Statistics in Medicine 27(10):1693-1702, 2008). The interval of w is the mid-p one, so the joint interval leaves out 0 where
  the mid-p McNemar test does (M. W. Fagerland, S. Lydersen, P. Laake, "The McNemar test for binary matched-pairs data: mid-p and
  asymptotic are better than exact conditional", BMC Medical Research Methodology 13:91, 2013). By exact sums over 70 tables of
  32, 64 and 256 flights each it covers 0.950 at least and 0.967 to 0.983 on average; without a difference it lies on the
  better side in at most 2.5 %. Two exact intervals at the root of the confidence each, the rule before, covered 0.979 to 0.983
  at least; with 64 flights it left out 0 in 32 % of these tables on average, this one in 38 %.

Every risk of such a quantity is an increasing function of the share, which carries its ends over.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from objectives.risk.measures import Interval, Risk

Values = NDArray[np.float64]
Counts = NDArray[np.int64] | int
N_HALVINGS = 60
"""Halvings of [0, 1] after which doubles end."""


def clopper_pearson(events: Counts, count: Counts, confidence: float = 0.95) -> Interval:
    """Return the two-sided interval of the share `events` (...) of `count` (...); [0, 1] of none."""
    # SciPy takes 0.2 s to import, and not every command has shares.
    from scipy.special import betaincinv  # pyright: ignore[reportMissingTypeStubs]

    k, n = np.broadcast_arrays(np.asarray(events, dtype=float), np.asarray(count, dtype=float))
    tail = 0.5 * (1.0 - confidence)
    low = np.where(k > 0.0, betaincinv(np.maximum(k, 1.0), n - k + 1.0, tail), 0.0)
    high = np.where(k < n, betaincinv(k + 1.0, np.maximum(n - k, 1.0), 1.0 - tail), 1.0)
    return Interval(low, high)


def mid_p_interval(events: Counts, count: Counts, confidence: float = 0.95) -> Interval:
    """Return the two-sided mid-p interval of the share `events` (...) of `count` (...); [0, 1] of none."""
    k, n = np.broadcast_arrays(np.asarray(events, dtype=float), np.asarray(count, dtype=float))
    tail = 0.5 * (1.0 - confidence)
    low = np.where(k > 0.0, _bisect(lambda share: _mid_p(k, n, share) - tail, k.shape), 0.0)
    high = np.where(k < n, _bisect(lambda share: tail - _mid_p(n - k, n, 1.0 - share), k.shape), 1.0)
    return Interval(low, high)


def _mid_p(k: Values, n: Values, share: Values) -> Values:
    """Return P(X > k) + P(X = k) / 2 of a binomial X of n at a share."""
    from scipy.special import betainc  # pyright: ignore[reportMissingTypeStubs]

    at_least = betainc(np.maximum(k, 1.0), n - k + 1.0, share)
    more = np.where(k < n, betainc(k + 1.0, np.maximum(n - k, 1.0), share), 0.0)
    return 0.5 * (np.where(k > 0.0, at_least, 1.0) + more)


def _bisect(rising: Callable[[Values], Values], shape: tuple[int, ...]) -> Values:
    """Return the roots (...) of functions that rise on [0, 1]."""
    low, high = np.zeros(shape), np.ones(shape)
    for _ in range(N_HALVINGS):
        middle = 0.5 * (low + high)
        is_above = rising(middle) > 0.0
        low, high = np.where(is_above, low, middle), np.where(is_above, middle, high)
    return 0.5 * (low + high)


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
    mine, other = np.asarray(first), np.asarray(second)
    different = mine + other
    often, share = clopper_pearson(different, count, confidence), different / count
    value = (mine - other) / count
    split = mid_p_interval(mine, different, confidence)
    # Of 2 w - 1, where none is different the middle of [-1, 1].
    balance = (mine - other) / np.maximum(different, 1)
    low, high = 2.0 * split.low - 1.0, 2.0 * split.high - 1.0
    # The distance of w counts times q, and that of q times 2 w - 1, each at the end that is sought.
    below = np.hypot(share * (balance - low), low * (np.where(low < 0.0, often.high, often.low) - share))
    above = np.hypot(share * (high - balance), high * (np.where(high > 0.0, often.high, often.low) - share))
    return Interval(value - below, value + above)


def risk_of_share(share: Values, risk: Risk) -> Values:
    """Return the risk (...) of a Bernoulli variable of probability `share` (...)."""
    if risk.is_mean:
        return share
    if risk.name == "cvar":
        return np.minimum(share / (1.0 - (risk.level or 0.0)), 1.0)
    return (share > (1.0 - (risk.level or 0.0) if risk.name == "quantile" else 0.0)).astype(float)


def _events(values: Values | NDArray[np.bool_]) -> NDArray[np.int64]:
    return np.count_nonzero(values, axis=-1)
