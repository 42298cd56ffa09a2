"""Gaussian process regression on the unit cube.

C. E. Rasmussen, C. K. I. Williams, "Gaussian Processes for Machine Learning", MIT Press 2006, chapters 2 and 5. Its length
scales, one for each coordinate, and its noise are maximum a posteriori estimates under a prior that expects smoother functions in
more dimensions (C. Hvarfner, E. O. Hellsten, L. Nardi, "Vanilla Bayesian optimization performs great in high dimensions", ICML
2024).
"""

from collections.abc import Callable
from functools import cache
from math import log, sqrt

import numpy as np

from tuner.search import covariance

Array = np.ndarray
# Ranges of the length scale, in edges of the cube, and of the noise's share of the variance.
LENGTHS, NOISES = (0.03, 30.0), (1e-6, 0.1)
# Logarithm of a length scale under the prior: mean for d coordinates this plus log(d) / 2, and standard deviation.
LENGTH_MEAN, LENGTH_STD = 2.0**0.5, 3.0**0.5
# Logarithm of the noise: flights through common scenarios have next to none.
NOISE_MEAN, NOISE_STD = log(1e-4), 2.0
# Largest numbers of points in a fit of the length scales, of likelihoods from the prior's mean, and of those from an earlier fit.
MAX_FIT_POINTS, MAX_FIRST_EVALUATIONS, MAX_EVALUATIONS = 128, 60, 20
# Longest step of a logarithm, and gain in log likelihood below which the fit has converged.
MAX_STEP, TOLERANCE = 1.5, 1e-5
# Share of the variance added on the diagonal of joint samples: points of a pool may nearly coincide.
NUGGET = 1e-7


class Hyperparameters:
    """Length scales and noise of a Gaussian process. logs (d + 1,): of the inverse length scales and of the noise."""

    def __init__(self, logs: Array) -> None:
        self.logs = logs
        self.scales = np.exp(logs[:-1])
        self.noise = float(np.exp(logs[-1]))

    @classmethod
    def prior(cls, dimensions: int) -> "Hyperparameters":
        """Return the mean of the prior."""
        return cls(log_prior(dimensions)[0])


@cache
def log_prior(dimensions: int) -> tuple[Array, Array]:
    """Return mean and standard deviation (d + 1,) of the logarithms under the prior."""
    mean = np.append(np.full(dimensions, -(LENGTH_MEAN + 0.5 * log(dimensions))), NOISE_MEAN)
    return mean, np.append(np.full(dimensions, LENGTH_STD), NOISE_STD)


def negative_log_posterior(logs: Array, points: Array, targets: Array) -> tuple[float, Array]:
    """Return the negative log posterior of logs (d + 1,) and its gradient: up to a constant."""
    value, gradient = covariance.likelihood(points, targets, logs)
    mean, std = log_prior(len(logs) - 1)
    deviation = (logs - mean) / std
    return value + 0.5 * float(np.square(deviation).sum()), gradient + deviation / std


def fit_hyperparameters(points: Array, targets: Array, start: Hyperparameters | None = None) -> Hyperparameters:
    """Return the maximum a posteriori estimate for targets (n,) at points (n, d); start: an earlier estimate."""
    first = start or Hyperparameters.prior(points.shape[1])
    if np.ptp(targets) == 0.0:
        return first
    subset, targets, _ = fit_data(points, targets)
    low = np.append(np.full(points.shape[1], -log(LENGTHS[1])), log(NOISES[0]))
    high = np.append(np.full(points.shape[1], -log(LENGTHS[0])), log(NOISES[1]))

    def function(logs: Array) -> tuple[float, Array]:
        return negative_log_posterior(logs, subset, targets)

    if start is None:
        return Hyperparameters(minimize_bfgs(function, first.logs, low, high, MAX_FIRST_EVALUATIONS)[0])
    # An earlier optimum of few points may be a local one: the prior's mean is a second start.
    starts = (start, Hyperparameters.prior(points.shape[1]))
    optima = [minimize_bfgs(function, entry.logs, low, high, MAX_EVALUATIONS) for entry in starts]
    return Hyperparameters(min(optima, key=lambda optimum: optimum[1])[0])


def fit_data(points: Array, targets: Array) -> tuple[Array, Array, float]:
    """Return points and standardized targets of a fit, and their standard deviation."""
    rows = np.unique(np.linspace(0, len(points) - 1, MAX_FIT_POINTS).astype(int))
    standardized, _, std = standardize(targets[rows])
    return np.ascontiguousarray(points[rows]), standardized, std


def mean_log_density(points: Array, targets: Array, hyperparameters: Hyperparameters) -> float:
    """Return the log posterior density of targets (n,) for each of them: up to a constant."""
    subset, standardized, std = fit_data(points, targets)
    return -negative_log_posterior(hyperparameters.logs, subset, standardized)[0] / len(subset) - log(std)


def minimize_bfgs(
    function: Callable[[Array], tuple[float, Array]], start: Array, low: Array, high: Array, evaluations: int
) -> tuple[Array, float]:
    """Return a local minimizer (k,) of a function, and its value.

    Projected BFGS between bounds: J. Nocedal, S. J. Wright, "Numerical Optimization", Springer 2006, chapter 6; steps end at the
    bounds. A library's takes, at this size, longer than the likelihood that it minimizes.

    Args:
        function: returns value and gradient (k,) at a point (k,).
        start: first point (k,).
        low: lower bounds (k,).
        high: upper bounds (k,).
        evaluations: largest number of calls of the function.
    """
    at = np.minimum(np.maximum(start, low), high)
    value, gradient = function(at)
    inverse_hessian, length = np.eye(len(at)), 1.0
    for _ in range(evaluations - 1):
        free = ~(((at <= low) & (gradient > 0.0)) | ((at >= high) & (gradient < 0.0)))
        direction = -np.where(free, (inverse_hessian * np.where(free, gradient, 0.0)).sum(axis=1), 0.0)
        if (direction * gradient).sum() >= 0.0:
            inverse_hessian, direction = np.eye(len(at)), -np.where(free, gradient, 0.0)
        ahead = at + length * direction * min(1.0, MAX_STEP / (np.abs(direction).max() or 1.0))
        trial = np.minimum(np.maximum(ahead, low), high)
        trial_value, trial_gradient = function(trial)
        step, gradient_change = trial - at, trial_gradient - gradient
        if trial_value > value + 1e-4 * (gradient * step).sum():
            length *= 0.3
            continue
        decrease, length = value - trial_value, 1.0
        at, value, gradient = trial, trial_value, trial_gradient
        if decrease < TOLERANCE:
            break
        inverse_hessian = bfgs_update(inverse_hessian, step, gradient_change)
    return at, value


def bfgs_update(inverse_hessian: Array, step: Array, gradient_change: Array) -> Array:
    """Return the BFGS update (k, k) of an inverse Hessian; itself where the curvature condition fails."""
    curvature = float((step * gradient_change).sum())
    if curvature <= 1e-10:
        return inverse_hessian
    image = (inverse_hessian * gradient_change).sum(axis=1)
    factor = (1.0 + float((gradient_change * image).sum()) / curvature) / curvature
    mixed = image[:, None] * step
    return inverse_hessian + factor * (step[:, None] * step) - (mixed + mixed.T) / curvature


def standardize(targets: Array) -> tuple[Array, float, float]:
    """Return standardized targets (n,), their mean and their standard deviation: 1 where it is 0."""
    mean, std = float(targets.mean()), float(targets.std()) or 1.0
    return (targets - mean) / std, mean, std


class GaussianProcess:
    """A Gaussian process with given hyperparameters, conditioned on targets (n,) at points (n, d)."""

    def __init__(self, points: Array, targets: Array, hyperparameters: Hyperparameters) -> None:
        self._hyperparameters, self._scaled = hyperparameters, points * hyperparameters.scales
        self._upper = covariance.cholesky_correlation(self._scaled, hyperparameters.noise)
        standardized_targets, self._mean, self._std = standardize(targets)
        self._half = covariance.solve_triangular(self._upper, standardized_targets[:, None])[:, 0]
        # The most likely variance, bounded from below by a millionth of that of the targets.
        self._variance = self._std**2 * max(float(np.square(self._half).mean()), 1e-6)

    def posterior(self, points: Array, jointly: bool = False) -> "Posterior":
        """Return the posterior at points (p, d).

        jointly: whether it has joint samples.
        """
        scaled = points * self._hyperparameters.scales
        mean, share, explained = covariance.condition(self._upper, self._half, self._scaled, scaled, jointly)
        return Posterior(self._mean + self._std * mean, self._variance, share, (scaled, explained) if jointly else None)


class Posterior:
    """Normal distribution of a quantity at some points.

    mean, std (p,): of each point by itself.

    Args:
        mean: mean (p,).
        variance: variance where nothing is known.
        share: explained share of it (p,).
        joint: the points (p, d) in length scales, and what explains them (n, p); None where it has no joint
            samples.
    """

    def __init__(self, mean: Array, variance: float, share: Array, joint: tuple[Array, Array] | None) -> None:
        self.mean = mean
        self._root, self._joint = sqrt(variance), joint
        self.std = self._root * np.sqrt(np.maximum(1.0 - share, NUGGET))

    def samples(self, normals: Array) -> Array:
        """Return joint samples (s, p) made of independent standard normal numbers (s, p)."""
        assert self._joint is not None, "they were requested"
        upper = covariance.cholesky_posterior(*self._joint, NUGGET)
        return self.mean + self._root * covariance.sample_normal(upper, normals)

    def cdf(self, level: float) -> Array:
        """Return the probabilities (p,) of values up to a level."""
        from scipy.special import ndtr

        return ndtr((level - self.mean) / self.std)
