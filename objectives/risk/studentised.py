"""Studentised bootstrap (bootstrap-t): intervals that hold what they promise for means and tails of skewed values.

Each resample is measured in its own standard error, t = (risk* - risk)/se*, and the interval is risk - t_97.5 se to
risk - t_2.5 se. Source: B. Efron, R. J. Tibshirani, "An Introduction to the Bootstrap", Chapman & Hall, 1993, section
12.5. The standard error is that of the influence function (F. R. Hampel, JASA 69(346):383-393, 1974): x itself for the mean
and q + max(x - q, 0)/(1 - a) for CVaR at level a with quantile q, whose mean is the CVaR (Rockafellar, Uryasev, 2000).

Measured on 800 repetitions with 256 values, CVaR at 0.95: the percentile interval covers 87 to 89 %, BCa 90 to 91 %, this one
94 to 95 % (normal, lognormal with sigma 0.5 and 1). Single order statistics (quantile, worst) have no standard error in the
sample and keep the percentile interval, which covers 94 to 96 % for the quantile. A resample that finds a quantity constant
cannot be measured in its standard error of zero and is left out, as long as such are fewer than the tail: with 5 flights in the
tail (CVaR of lognormal values, sigma 0.6) intervals then cover 91 to 93 %, where percentiles covered 86 to 88 %. Shares have
exact intervals (`objectives.risk.shares`).
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.risk.measures import Risk, quantile_rank

Values = NDArray[np.float64]

# A standard error below this share of the largest resampled risk is rounding.
ROUNDING = 1e-12


class Resampled(NamedTuple):
    """A risk on every resample: drawn (replicates,), and its standard errors (replicates,), 0 for a risk without one."""

    drawn: Values
    errors: Values


class MeasuredRisk(NamedTuple):
    """Risk (...) of samples (..., n) and its influence values (..., n).

    pull: None for a risk without.
    """

    risk: Values
    pull: Values | None


def measured(values: Values, risk: Risk) -> MeasuredRisk:
    """Return the risk of values (..., n) and what pulls at it; up to rounding the risk is that of `Risk.apply`."""
    if risk.is_mean:
        return MeasuredRisk(np.mean(values, axis=-1), values)
    if risk.name == "cvar" and risk.level is not None:
        rank = quantile_rank(risk.level, values.shape[-1])
        edge = np.partition(values, rank - 1, axis=-1)[..., rank - 1 : rank]
        pull = np.maximum(values - edge, 0.0) / (1.0 - risk.level)
        return MeasuredRisk(edge[..., 0] + np.mean(pull, axis=-1), pull)
    return MeasuredRisk(risk.apply(values), None)


def difference(first: MeasuredRisk, second: MeasuredRisk) -> MeasuredRisk:
    """Return the difference of two risks on the same scenarios."""
    pull = None if first.pull is None or second.pull is None else first.pull - second.pull
    return MeasuredRisk(first.risk - second.risk, pull)


def standard_error(measured_risk: MeasuredRisk) -> Values:
    """Return the standard error (...) of a risk, 0 where it has none."""
    if measured_risk.pull is None:
        return np.zeros_like(measured_risk.risk)
    return np.std(measured_risk.pull, axis=-1) / sqrt(measured_risk.pull.shape[-1])


def ends(value: float, error: float, sampled: Resampled, confidence: float) -> tuple[float, float]:
    """Return the interval ends of a risk by value and standard error."""
    tails = [0.5 * (1.0 - confidence), 0.5 * (1.0 + confidence)]
    least = ROUNDING * np.max(np.abs(sampled.drawn), axis=0)
    measurable = sampled.errors > least
    # They count as the lowest t of all: beyond the tail, an upper end that leaves them out would be too low.
    if error <= least or np.mean(~measurable, axis=0) > tails[0]:
        low, high = np.quantile(sampled.drawn, tails, axis=0)
        return float(low), float(high)
    low, high = np.quantile((sampled.drawn[measurable] - value) / sampled.errors[measurable], tails, axis=0)
    return value - float(high) * error, value - float(low) * error
