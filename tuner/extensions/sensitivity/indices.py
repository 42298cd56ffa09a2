"""Sobol indices: shares of the variance of an output that each input explains, alone and with its interactions.

First order S_i = V[E(y | x_i)] / V[y]; total T_i = 1 - V[E(y | all but x_i)] / V[y]. Estimators (b) and (f) of Table 2 in
Saltelli et al. 2010 (see `tuner.extensions.sensitivity.design`), as implemented by `scipy.stats.sobol_indices`. Estimates may
lie a little below 0 or above 1.

The intervals are percentile bootstraps over the base samples, taken as independent; for a Sobol sequence they are conservative.
SciPy's own bootstrap takes no seed and is not used.

A failed flight costs more than any completed one (`objectives.metrics.evaluate`) and would dominate the
variance; hence two scales:

- rank: a candidate's place among all samples, 0 the best and 1 the worst; independent of the cost of failures. Interactions that
  only bend the scale do not show (A. Saltelli, I. M. Sobol, Reliability Engineering & System Safety 50(3):225-239, 1995).
- value: the objective in its unit, clipped to the largest value of any sample without failures.
"""

from typing import NamedTuple

import numpy as np

from plant.ties import mean_ranks
from tuner.extensions.sensitivity.design import SobolDesign

Array = np.ndarray
REPLICATES, TAILS = 1000, (0.025, 0.975)
RANK, VALUE = "rank", "value"
SCALES = (RANK, VALUE)
"""Scales on which the variance of an objective is explained."""


class Spans(NamedTuple):
    """Indices (q, d) of outputs to inputs, with 95 % intervals."""

    value: Array
    low: Array
    high: Array


class Indices(NamedTuple):
    """First-order and total indices. An output that never changes has zeros."""

    first: Spans
    total: Spans


def sobol_spans(design: SobolDesign, values: Array, draw: np.random.Generator, replicates: int = REPLICATES) -> Indices:
    """Return the Sobol indices of outputs (n (d + 2), q), finite: at a design's points."""
    from scipy.stats import sobol_indices

    f_a, f_b, f_ab = design.split(values)
    estimates = sobol_indices(func={"f_A": f_a, "f_B": f_b, "f_AB": f_ab}, n=design.base)
    shape = values.shape[1], design.dimensions
    # Rounding makes the variance of equal numbers 1e-33 instead of 0.
    changes = (np.ptp(values, axis=0) > 0.0)[:, None]
    ends = _bootstrap(f_a, f_b, f_ab, draw, replicates)
    points = (np.reshape(order, shape) for order in (estimates.first_order, estimates.total_order))
    first, total = (
        Spans(*(np.where(changes, part, 0.0) for part in (point, *end)))
        for point, end in zip(points, ends, strict=True)
    )
    return Indices(first, total)


def _bootstrap(f_a: Array, f_b: Array, f_ab: Array, draw: np.random.Generator, replicates: int) -> tuple[Array, Array]:
    """Return the ends (2, q, d) of the intervals of first-order and of total indices.

    Every estimator is a ratio of means over the base samples, so a resample is a row of weights.
    """
    n = f_a.shape[1]
    weights = draw.multinomial(n, np.full(n, 1.0 / n), size=replicates) / n
    center = 0.5 * (f_a.mean(axis=1) + f_b.mean(axis=1))[:, None]
    a, b, ab = f_a - center, f_b - center, f_ab - center
    mean = 0.5 * weights @ (a + b).T
    variance = 0.5 * weights @ (a**2 + b**2).T - mean**2
    first = np.stack([weights @ (b * (page - a)).T for page in ab], axis=-1)
    total = np.stack([0.5 * weights @ ((a - page) ** 2).T for page in ab], axis=-1)
    # A resample may hold nothing but equal values: then it explains nothing.
    safe = np.where(variance > 0.0, variance, np.inf)[..., None]
    return np.quantile(first / safe, TAILS, axis=0), np.quantile(total / safe, TAILS, axis=0)


def ranks(values: Array) -> Array:
    """Return the ranks (n, q) of values (n, q) in each column, between 0 and 1; equal values share their mean rank."""
    return (np.stack([mean_ranks(column) for column in values.T], axis=1) - 0.5) / len(values)


def clip_to_completed(values: Array, failures: Array) -> Array:
    """Return values (n, q) clipped to the largest ones without failures (n,), if any."""
    complete = failures == 0.0
    return np.minimum(values, values[complete].max(axis=0)) if complete.any() else values
