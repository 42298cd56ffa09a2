"""The scales on which the variance of an objective is explained.

A failed flight costs more than any completed one, a hundred times the usual value and more (`objectives.metrics.evaluate`): the
plain variance over the ranges of the gains is then that of the failures, and its indices say which gains lose flights.

- rank: a candidate's place among all samples, 0 the best and 1 the worst. It is monotone, bounded and the same whatever a
  failure is said to cost, and it is what a search by dominance sees; so these are the indices to read first. Interactions that
  only bend the scale are not seen (A. Saltelli, I. M. Sobol, Reliability Engineering & System Safety 50(3):225-239, 1995).
- value: the objective in its own unit, held to the largest value of any sample that lost no flight. Without failures it is
  the objective itself.
"""

import numpy as np

Array = np.ndarray
RANK, VALUE = "rank", "value"
SCALES = (RANK, VALUE)


def ranks(values: Array) -> Array:
    """Return the ranks (n, q) of values (n, q) in each column, between 0 and 1; equal values share their mean rank."""
    from scipy.stats import rankdata

    return (rankdata(values, axis=0) - 0.5) / len(values)


def held_to_completed(values: Array, failures: Array) -> Array:
    """Return values (n, q) held to the largest among the samples whose share of failures (n,) is 0; all kept if none is."""
    complete = failures == 0.0
    return np.minimum(values, values[complete].max(axis=0)) if complete.any() else values
