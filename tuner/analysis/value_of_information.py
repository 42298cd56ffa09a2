"""Value of information: the improvement that exact knowledge of vehicle parameters would allow.

All candidates fly the same flights; each flight has its own draw of the uncertain parameters. The expected value of
partial perfect information (EVPPI) of a parameter is estimated by regression of the objective on it (M. Strong, J. E. Oakley,
A. Brennan, Medical Decision Making 34(3):311-326, 2014). Its upward bias is the mean over random permutations, and is
subtracted. The share of variance explained is the correlation ratio (M. D. McKay, LA-12915, 1995).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

N_PERMUTATIONS = 100
"""Permutations of the flights."""
LEVEL = 0.95
"""Share of the permutations that a significant value exceeds."""
FLIGHTS_PER_TERM = 8
"""Flights for each term of a regression on all parameters, below which it has no squares."""
MIN_FLIGHTS = 32
"""Flights below which nothing is estimated."""


@dataclass(frozen=True)
class ValueOfInformation:
    """EVPPI and correlation ratio of a parameter, or of all.

    Attributes:
        value: EVPPI of the mean objective, unbiased, 0 where not significant.
        is_significant, is_share_significant: True if they exceed those of the permutations.
        share: Correlation ratio at the reference.
    """

    value: float
    is_significant: bool
    share: float
    is_share_significant: bool


def values_of_information(
    samples: Array, parameters: Array, reference: int, rng: np.random.Generator
) -> tuple[ValueOfInformation, list[ValueOfInformation]]:
    """Return the value of information of all parameters together, and of each.

    Args:
        samples: an objective (points, flights), the smaller the better.
        parameters: sampled parameters (flights, n), standardized.
        reference: row of the point whose variance is explained.
        rng: source of the permutations.
    """
    permutations = [rng.permutation(samples.shape[1]) for _ in range(N_PERMUTATIONS)]
    each = [
        _estimate(samples, regression_basis(column[:, None], True), reference, permutations) for column in parameters.T
    ]
    quadratic = samples.shape[1] >= FLIGHTS_PER_TERM * (1 + 2 * parameters.shape[1])
    return _estimate(samples, regression_basis(parameters, quadratic), reference, permutations), each


def _estimate(samples: Array, basis: Array, reference: int, permutations: list[NDArray[np.intp]]) -> ValueOfInformation:
    def estimates(basis: Array) -> tuple[float, float]:
        return evppi(samples, basis), correlation_ratio(samples[reference], basis)

    value, share = estimates(basis)
    null = np.array([estimates(basis[order]) for order in permutations])
    is_significant, is_share_significant = np.array([value, share]) > np.quantile(null, LEVEL, axis=0)
    unbiased = max(value - float(null[:, 0].mean()), 0.0) if is_significant else 0.0
    return ValueOfInformation(unbiased, bool(is_significant), share, bool(is_share_significant))


def regression_basis(parameters: Array, quadratic: bool) -> Array:
    """Return an orthonormal basis (flights, terms) of constant, linear and, optionally, quadratic terms."""
    columns = [np.ones((len(parameters), 1)), parameters, *([parameters**2] if quadratic else [])]
    return np.linalg.qr(np.concatenate(columns, axis=1))[0]


def evppi(objective: Array, basis: Array) -> float:
    """Return the EVPPI before bias correction: min of the means less the mean of the minima of the fitted values."""
    fitted = (objective @ basis) @ basis.T
    return float(np.min(np.mean(objective, axis=1)) - np.mean(np.min(fitted, axis=0)))


def correlation_ratio(y: Array, basis: Array) -> float:
    """Return the adjusted R^2 of y (flights,) on the basis: the share of variance explained, at least 0."""
    n, p = basis.shape
    residual = y - basis @ (basis.T @ y)
    variance = float(np.var(y, ddof=1))
    return max(1.0 - float(residual @ residual) / (n - p) / variance, 0.0) if variance > 0.0 else 0.0
