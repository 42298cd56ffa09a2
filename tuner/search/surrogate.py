"""A Gaussian process: what is likely of a quantity at points of the unit cube that nobody has tried.

C. E. Rasmussen, C. K. I. Williams, "Gaussian Processes for Machine Learning", MIT Press 2006, chapters 2 and 5. Its length
scales, one for each coordinate, and its noise are the most likely ones under a prior that expects smoother functions in more
dimensions (C. Hvarfner, E. O. Hellsten, L. Nardi, "Vanilla Bayesian optimization performs great in high dimensions", ICML 2024).
"""

from collections.abc import Callable
from math import log, sqrt

import numpy as np

from tuner.search.covariance import (
    correlations,
    drawn,
    factored_correlations,
    factored_remainder,
    half_solved,
    likelihood,
)

Array = np.ndarray
# Ranges of the length scale, in edges of the cube, and of the noise's share of the variance.
LENGTHS, NOISES = (0.03, 30.0), (1e-6, 0.1)
# Logarithm of a length scale under the prior: mean for d coordinates this plus log(d) / 2, and standard deviation.
LENGTH_MEAN, LENGTH_SPREAD = 2.0**0.5, 3.0**0.5
# Logarithm of the noise: flights through common scenarios have next to none.
NOISE_MEAN, NOISE_SPREAD = log(1e-4), 2.0
# Points that the length scales are read from, evaluations of the likelihood to find them from the prior's mean and from those
# found before.
FITTED, FIRST_STEPS, STEPS = 128, 60, 20
# Longest step of a logarithm, and gain in log likelihood that is not worth another.
LONGEST, ENOUGH = 1.5, 1e-5
# Share of the variance on the diagonal of what is drawn jointly: points of a pool may be next to each other.
NUGGET = 1e-7


class Shape:
    """Length scales and noise of a Gaussian process. logs (d + 1,): of the inverse length scales and of the noise."""

    def __init__(self, logs: Array) -> None:
        self.logs = logs
        self.scales = np.exp(logs[:-1])
        self.noise = float(np.exp(logs[-1]))

    @classmethod
    def expected(cls, dimensions: int) -> "Shape":
        """Return the mean of the prior."""
        return cls(prior_mean(dimensions))


def prior_mean(dimensions: int) -> Array:
    """Return the logarithms (d + 1,) that the prior expects."""
    return np.append(np.full(dimensions, -(LENGTH_MEAN + 0.5 * log(dimensions))), NOISE_MEAN)


def misfit(logs: Array, points: Array, targets: Array) -> tuple[float, Array]:
    """Return the negative log posterior of logs (d + 1,) but for a constant, and its slope."""
    value, slope = likelihood(points, targets, logs)
    spread = np.append(np.full(len(logs) - 1, LENGTH_SPREAD), NOISE_SPREAD)
    off = (logs - prior_mean(len(logs) - 1)) / spread
    return value + 0.5 * float(np.square(off).sum()), slope + off / spread


def fitted_shape(points: Array, targets: Array, before: Shape | None = None) -> Shape:
    """Return the most likely shape for targets (n,) at points (n, d); before: where to look first."""
    if np.ptp(targets) == 0.0:
        return before or Shape.expected(points.shape[1])
    rows = np.unique(np.linspace(0, len(points) - 1, FITTED).astype(int))
    targets = standardised(targets[rows])[0]
    start = before or Shape.expected(points.shape[1])
    low = np.append(np.full(points.shape[1], -log(LENGTHS[1])), log(NOISES[0]))
    high = np.append(np.full(points.shape[1], -log(LENGTHS[0])), log(NOISES[1]))
    near = np.ascontiguousarray(points[rows])
    steps = FIRST_STEPS if before is None else STEPS
    return Shape(minimised(lambda logs: misfit(logs, near, targets), start.logs, low, high, steps))


def minimised(
    function: Callable[[Array], tuple[float, Array]], start: Array, low: Array, high: Array, evaluations: int
) -> Array:
    """Return where a function, which returns value and slope (k,), is small between low and high (k,).

    A quasi-Newton method (BFGS; J. Nocedal, S. J. Wright, "Numerical Optimization", Springer 2006, chapter 6) whose steps end at
    the bounds. It stands here because a library's, at this size, takes longer than the likelihood that it is to minimise.
    """
    at = np.clip(start, low, high)
    value, slope = function(at)
    bend, length = np.eye(len(at)), 1.0
    for _ in range(evaluations - 1):
        free = ~(((at <= low) & (slope > 0.0)) | ((at >= high) & (slope < 0.0)))
        step = -np.where(free, (bend * np.where(free, slope, 0.0)).sum(axis=1), 0.0)
        if np.sum(step * slope) >= 0.0:
            bend, step = np.eye(len(at)), -np.where(free, slope, 0.0)
        there = np.clip(at + length * step * min(1.0, LONGEST / (np.abs(step).max() or 1.0)), low, high)
        found, slope_there = function(there)
        moved, turned = there - at, slope_there - slope
        if found > value + 1e-4 * np.sum(slope * moved):
            length *= 0.3
            continue
        gained, length = value - found, 1.0
        at, value, slope = there, found, slope_there
        if gained < ENOUGH:
            break
        bend = updated(bend, moved, turned)
    return at


def updated(bend: Array, moved: Array, turned: Array) -> Array:
    """Return the estimate (k, k) of the inverse curvature after a move (k,) that turned the slope by (k,)."""
    along = float(np.sum(moved * turned))
    if along <= 1e-10:
        return bend
    image = (bend * turned).sum(axis=1)
    ahead = (1.0 + float(np.sum(turned * image)) / along) / along
    return bend + ahead * np.outer(moved, moved) - (np.outer(image, moved) + np.outer(moved, image)) / along


def standardised(targets: Array) -> tuple[Array, float, float]:
    """Return targets (n,) less their mean in standard deviations, the mean, and the deviation: 1 where it is 0."""
    mean, deviation = float(targets.mean()), float(targets.std()) or 1.0
    return (targets - mean) / deviation, mean, deviation


class Surrogate:
    """The Gaussian process of a shape, told targets (n,) at points (n, d)."""

    def __init__(self, points: Array, targets: Array, shape: Shape) -> None:
        self._shape, self._scaled = shape, points * shape.scales
        self._upper = factored_correlations(self._scaled, shape.noise)
        told, self._mean, deviation = standardised(targets)
        self._half = half_solved(self._upper, told[:, None])[:, 0]
        # The most likely variance, but not below what the targets have in units of their own spread over a thousand.
        self._variance = deviation**2 * max(float(np.square(self._half).mean()), 1e-6)
        self._deviation = deviation

    def at(self, points: Array) -> "Expectation":
        """Return what is expected at points (p, d)."""
        scaled = points * self._shape.scales
        explained = half_solved(self._upper, correlations(self._scaled, scaled))
        mean = self._mean + self._deviation * (explained * self._half[:, None]).sum(axis=0)
        return Expectation(mean, self._variance, explained, scaled)


class Expectation:
    """The joint normal distribution of a quantity at some points. mean, deviation (p,): of each by itself."""

    def __init__(self, mean: Array, variance: float, explained: Array, scaled: Array) -> None:
        self.mean = mean
        self._root, self._explained, self._scaled = sqrt(variance), explained, scaled
        self.deviation = self._root * np.sqrt(np.maximum(1.0 - np.square(explained).sum(axis=0), NUGGET))

    def samples(self, normals: Array) -> Array:
        """Return samples (s, p) made of independent standard normal numbers (s, p)."""
        upper = factored_remainder(self._scaled, self._explained, NUGGET)
        return self.mean + self._root * drawn(upper, normals)

    def chance_below(self, level: float) -> Array:
        """Return the probability (p,) of values up to a level."""
        from scipy.special import ndtr

        return ndtr((level - self.mean) / self.deviation)
