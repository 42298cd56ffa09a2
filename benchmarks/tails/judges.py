"""Limit functions whose probability of failure is known exactly, without any sampling; they import nothing of the product.

Each maps rows of standard normals to one column, demand over capacity.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.signal import lfilter
from scipy.stats import norm

Array = np.ndarray


def nodes(low: float, high: float, count: int) -> tuple[Array, Array]:
    """Return the points and weights of Gauss and Legendre on an interval."""
    points, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (high - low) * points + 0.5 * (high + low), 0.5 * (high - low) * weights


@dataclass(frozen=True)
class FirstPassage:
    """A stationary Ornstein-Uhlenbeck process of unit variance that reaches a limit at one of `dimension` samples."""

    limit: float
    step: float = 0.1
    dimension: int = 100
    modes: tuple[str, ...] = ("passage",)

    def values(self, normals: Array) -> Array:
        """Return the largest sample over the limit (n, 1)."""
        memory = np.exp(-self.step)
        noise = np.sqrt(1.0 - memory**2) * normals
        noise[:, 0] = normals[:, 0]
        return np.max(lfilter([1.0], [1.0, -memory], noise, axis=1), axis=1, keepdims=True) / self.limit

    @cached_property
    def probability(self) -> float:
        """Return the exact probability: the density of what has not passed, propagated sample by sample."""
        memory = np.exp(-self.step)
        deviation = np.sqrt(1.0 - memory**2)
        points, weights = nodes(-8.0, self.limit, 600)
        kernel = norm.pdf((points - memory * points[:, None]) / deviation) / deviation * weights
        passing = norm.sf((self.limit - memory * points) / deviation)
        density, passed = norm.pdf(points) * weights, float(norm.sf(self.limit))
        for _ in range(self.dimension - 1):
            passed += float(density @ passing)
            density = density @ kernel
        return passed


@dataclass(frozen=True)
class Oscillator:
    """A lightly damped oscillator in white noise, of unit variance, that reaches a limit at one of `dimension` samples."""

    limit: float
    damping: float = 0.1
    step: float = 0.5
    dimension: int = 60
    modes: tuple[str, ...] = ("passage",)

    @property
    def coefficients(self) -> tuple[float, float, float, float]:
        """Return x_k = a x_(k-1) + b x_(k-2) + s w_k, and the correlation of neighbors."""
        decay = np.exp(-self.damping * self.step)
        a = 2.0 * decay * np.cos(np.sqrt(1.0 - self.damping**2) * self.step)
        b = -(decay**2)
        s = np.sqrt((1.0 + b) * ((1.0 - b) ** 2 - a**2) / (1.0 - b))
        return a, b, s, a / (1.0 - b)

    def values(self, normals: Array) -> Array:
        """Return the largest sample over the limit (n, 1)."""
        a, b, s, correlation = self.coefficients
        noise = s * normals
        noise[:, 0] = normals[:, 0]
        # The filter starts at rest, so the second sample's noise makes up for the memory of the first.
        second = correlation * normals[:, 0] + np.sqrt(1.0 - correlation**2) * normals[:, 1]
        noise[:, 1] = second - a * normals[:, 0]
        return np.max(lfilter([1.0], [1.0, -a, -b], noise, axis=1), axis=1, keepdims=True) / self.limit

    @cached_property
    def probability(self) -> float:
        """Return the exact probability: the density of two neighbors that have not passed, on a grid of both."""
        a, b, s, correlation = self.coefficients
        points, weights = nodes(-7.0, self.limit, 160)
        # [y, x, z]: from the samples x, y to y, z.
        mean = a * points[:, None] + b * points
        kernel = norm.pdf((points - mean[..., None]) / s) / s * weights
        passing = norm.sf((self.limit - mean) / s)
        spread = np.sqrt(1.0 - correlation**2)
        # [y, x]
        first = norm.pdf(points) * weights
        density = norm.pdf((points[:, None] - correlation * points) / spread) / spread * weights[:, None] * first
        passed = float(norm.sf(self.limit) + norm.sf((self.limit - correlation * points) / spread) @ first)
        for _ in range(self.dimension - 2):
            passed += float(np.sum(density * passing))
            # What was y is x of the next pair.
            density = np.einsum("yx,yxz->zy", density, kernel, optimize=True)
        return passed


@dataclass(frozen=True)
class OppositeModes:
    """Two failures in opposite directions, of unequal probability."""

    high: float
    low: float
    dimension: int = 20
    modes: tuple[str, ...] = ("either",)

    def values(self, normals: Array) -> Array:
        """Return the first normal over either limit (n, 1)."""
        return np.maximum(normals[:, :1] / self.high, -normals[:, :1] / self.low)

    @property
    def probability(self) -> float:
        """Return the exact probability."""
        return float(norm.sf(self.high) + norm.sf(self.low))


@dataclass(frozen=True)
class HiddenMode:
    """Two limits of which the farther one draws the ladder: the nearer one's demand rises late.

    K. Breitung, arXiv 1705.04453, example of piecewise linear limits, moved along both axes; its limits are 4 and 5.
    """

    near: float
    dimension: int = 2
    modes: tuple[str, ...] = ("either",)

    def values(self, normals: Array) -> Array:
        """Return 1 less the smaller of the two limits (n, 1)."""
        x, y = normals[:, 0] + 4.0 - self.near, normals[:, 1] + 4.0 - self.near
        late = np.where(x > 3.5, 4.0 - x, 0.85 - 0.1 * x)
        early = np.where(y > 2.0, 0.5 - 0.1 * y, 2.3 - y)
        return 1.0 - np.minimum(late, early)[:, None]

    @property
    def probability(self) -> float:
        """Return the exact probability."""
        return float(1.0 - norm.cdf(self.near) * norm.cdf(self.near + 1.0))


Judge = FirstPassage | Oscillator | OppositeModes | HiddenMode


def judges(probability: float) -> dict[str, Judge]:
    """Return the four limit functions, with limits of three digits at about a probability."""
    part = 0.8 * probability
    return {
        "first passage": _at(FirstPassage, probability),
        "oscillator": _at(Oscillator, probability),
        "opposite modes": OppositeModes(round(float(norm.isf(part)), 3), round(float(norm.isf(probability - part)), 3)),
        "hidden mode": _at(HiddenMode, probability),
    }


def _at(kind: Callable[[float], Judge], probability: float) -> Judge:
    """Return the judge of a limit of three digits, by bisection."""
    low, high = 3.0, 7.0
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if kind(middle).probability > probability else (low, middle)
    return kind(round(high, 3))
