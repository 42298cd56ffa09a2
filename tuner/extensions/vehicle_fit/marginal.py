"""Marginal posterior of a positive number that acts linearly, by quadrature.

A Gauss-Newton fit takes the posterior of the logarithm as normal. Of a number that the data hardly tell, the likelihood is normal
over the number itself: it falls off towards large numbers and stays flat towards 0, so a large estimate looks too certain.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

REACH = 6.0
"""Prior standard deviations to either side of the center in the integral."""
N_POINTS = 1201
"""Points of the quadrature."""


def marginal_moments(mode: float, variance: float, center: float, prior_std: float) -> tuple[float, float]:
    """Return mean and variance of the logarithm of a number.

    Its likelihood is normal over the number, its prior over the logarithm.

    Args:
        mode: Mode of the posterior.
        variance: Variance of the posterior as a normal one, at the mode.
        center: Center of the prior.
        prior_std: Standard deviation of the prior.
    """
    precision = 1.0 / variance - prior_std**-2
    if precision <= 0.0:
        return mode, variance
    # In units of the number at the mode: the gradients of likelihood and prior cancel there.
    peak = 1.0 + (mode - center) / (prior_std**2 * precision)
    x = center + prior_std * np.linspace(-REACH, REACH, N_POINTS)
    exponent = -0.5 * (precision * (np.exp(x - mode) - peak) ** 2 + ((x - center) / prior_std) ** 2)
    weights = np.exp(exponent - exponent.max())
    weights /= weights.sum()
    mean = float(weights @ x)
    return mean, float(weights @ (x - mean) ** 2)


def with_moments(estimate: Array, covariance: Array, k: int, mean: float, variance: float) -> tuple[Array, Array]:
    """Return estimate (n,) and covariance (n, n) with a coordinate's moments.

    The others follow by regression on it.
    """
    slope = covariance[:, k] / covariance[k, k]
    moved = estimate + slope * (mean - estimate[k])
    return moved, covariance + np.outer(slope, slope) * (variance - covariance[k, k])
