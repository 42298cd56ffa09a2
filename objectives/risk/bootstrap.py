"""Percentile bootstrap over scenarios: how far a risk would move if other scenarios had been drawn.

Use it for intervals of reported risks, and on paired scenarios to tell whether two candidates really differ. Whole
scenarios are resampled, never instants of one flight, because instants are dependent. All candidates see the same
resampled scenarios, so their replicates are paired as their flights are (common random numbers).

Source: B. Efron, R. J. Tibshirani, "An Introduction to the Bootstrap", Chapman & Hall, 1993, chapter 13. The interval
is a little too short for small samples: for the mean of n normal values its coverage is
P(|t_(n-1)| < z sqrt((n-1)/n)), 94 % instead of 95 % at n = 50. For the worst case it is not valid at all: no resample
exceeds the largest value seen.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.risk.measures import Risk
from plant.errors import InputError

BLOCK = 2_000_000
"""Numbers held at once while resampling, 16 MB; the resampled scenario indices come on top with replicates * n."""

Values = NDArray[np.float64]
Indices = NDArray[np.intp]


class Interval(NamedTuple):
    """Lower and upper end (...) of a confidence interval."""

    low: Values
    high: Values


class PairedDifference(NamedTuple):
    """Risk of the first minus risk of the second candidate (...) and its confidence interval; below 0: first better."""

    difference: Values
    low: Values
    high: Values


def bootstrap_interval(
    values: Values, risk: Risk, rng: np.random.Generator, replicates: int = 2000, confidence: float = 0.95
) -> Interval:
    """Return the percentile interval of the risk of values (..., n), n scenarios, for each leading entry.

    An entry's interval depends on its own values and the state of rng, not on the entries beside it.
    """
    values = np.asarray(values, dtype=np.float64)
    _check(values, replicates, confidence)
    resample = _resamples(rng, replicates, values.shape[-1])
    flat = values.reshape(-1, values.shape[-1])
    ends = _percentiles(len(flat), replicates, confidence, lambda rows: _replicates(flat[rows], risk, resample))
    return Interval(*ends.reshape(2, *values.shape[:-1]))


def bootstrap_replicates(
    values: Values, risk: Risk, rng: np.random.Generator, replicates: int = 2000
) -> NDArray[np.float64]:
    """Return the risk of every resample (..., replicates) of values (..., n), n scenarios.

    All entries see the same resamples, so differences of their replicates are those of `paired_difference`: use this for
    every pair among many candidates at the cost of one bootstrap each.
    """
    values = np.asarray(values, dtype=np.float64)
    _check(values, replicates, 0.5)
    found = _replicates(values.reshape(-1, values.shape[-1]), risk, _resamples(rng, replicates, values.shape[-1]))
    return found.reshape(*values.shape[:-1], replicates)


def percentile_interval(replicates: Values, confidence: float = 0.95) -> Interval:
    """Return the central share `confidence` of replicates (..., replicates) for each leading entry."""
    _check(replicates, replicates.shape[-1], confidence)
    return Interval(*np.quantile(replicates, _tails(confidence), axis=-1))


def paired_difference(
    values_a: Values,
    values_b: Values,
    risk: Risk,
    rng: np.random.Generator,
    replicates: int = 2000,
    confidence: float = 0.95,
) -> PairedDifference:
    """Return risk(a) - risk(b) with its percentile interval; a and b (..., n) flew through the same n scenarios."""
    first, second = np.asarray(values_a, dtype=np.float64), np.asarray(values_b, dtype=np.float64)
    if first.shape != second.shape:
        raise InputError(f"paired values must have one shape, but {first.shape} and {second.shape} were given")
    _check(first, replicates, confidence)
    n = first.shape[-1]
    resample = _resamples(rng, replicates, n)
    a, b = first.reshape(-1, n), second.reshape(-1, n)
    ends = _percentiles(
        len(a),
        replicates,
        confidence,
        lambda rows: _replicates(a[rows], risk, resample) - _replicates(b[rows], risk, resample),
    )
    low, high = ends.reshape(2, *first.shape[:-1])
    return PairedDifference(risk.apply(first) - risk.apply(second), low, high)


def _check(values: Values, replicates: int, confidence: float) -> None:
    if values.ndim == 0 or values.shape[-1] == 0:
        raise InputError("a bootstrap needs at least one scenario, but none was given")
    if replicates < 1:
        raise InputError(f"replicates = {replicates} must be at least 1; 2000 suits a 95 % interval")
    if not 0.0 < confidence < 1.0:
        raise InputError(f"confidence = {confidence} must lie between 0 and 1, for instance 0.95")


def _resamples(rng: np.random.Generator, replicates: int, n: int) -> Indices:
    return rng.integers(n, size=(replicates, n), dtype=np.intp)


def _percentiles(
    entries: int, replicates: int, confidence: float, replicates_of: Callable[[slice], Values]
) -> NDArray[np.float64]:
    """Return the ends (2, entries) of the central share `confidence` of replicates_of(rows) (rows, replicates)."""
    ends = np.empty((2, entries))
    rows_at_once = max(BLOCK // replicates, 1)
    for begin in range(0, entries, rows_at_once):
        rows = slice(begin, begin + rows_at_once)
        ends[:, rows] = np.quantile(replicates_of(rows), _tails(confidence), axis=-1)
    return ends


def _tails(confidence: float) -> list[float]:
    return [0.5 * (1.0 - confidence), 0.5 * (1.0 + confidence)]


def _replicates(values: Values, risk: Risk, resample: Indices) -> Values:
    """Return the risk of every resample: (rows, replicates) from values (rows, n) and indices (replicates, n)."""
    rows, n = values.shape
    found = np.empty((rows, len(resample)))
    at_once = max(BLOCK // n, 1)
    for row in range(rows):
        for begin in range(0, len(resample), at_once):
            chosen = slice(begin, begin + at_once)
            found[row, chosen] = risk.apply(values[row][resample[chosen]])
    return found
