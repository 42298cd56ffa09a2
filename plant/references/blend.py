"""Gentle changes of pace: the smoothstep 10 s^3 - 15 s^4 + 6 s^5, its derivative and its integral, all closed forms.

Used where a reference begins or stops moving. Velocity, acceleration and jerk are continuous at both ends of the blend,
so that a vehicle at rest is not kicked. The polynomial is the smootherstep of K. Perlin, Improving Noise, SIGGRAPH
2002.
"""

from typing import NamedTuple

import numpy as np


class Blend(NamedTuple):
    """A share rising from 0 to 1, its rate [1/s], and its integral from -infinity [s]; arrays as the times given."""

    share: np.ndarray
    rate: np.ndarray
    integral: np.ndarray


def blend(t: np.ndarray, start: float, duration: float) -> Blend:
    """Return the blend that is 0 up to `start` and 1 from `start + duration` on; duration > 0 [s]."""
    s = np.clip((t - start) / duration, 0.0, 1.0)
    share = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    rate = 30.0 * s**2 * (1.0 - s) ** 2 / duration
    beyond = np.maximum(t - start - duration, 0.0)
    integral = duration * s**4 * (2.5 - 3.0 * s + s**2) + beyond
    return Blend(share, rate, integral)


class Phase(NamedTuple):
    """Angle of a periodic motion [rad], its rate [rad/s] and acceleration [rad/s2], each (K,)."""

    angle: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray


def phase(t: np.ndarray, period: float) -> Phase:
    """Return the phase of a motion from rest at angle 0 that reaches its pace in one period.

    The first period thus takes half a turn, and each later one a whole turn.
    """
    pace = 2.0 * np.pi / period
    start = blend(t, 0.0, period)
    return Phase(pace * start.integral, pace * start.share, pace * start.rate)


def along(p: np.ndarray, dp: np.ndarray, ddp: np.ndarray, angle: Phase) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return position, velocity, acceleration (K, 3) of a curve p(angle) with derivatives dp and ddp."""
    rate, acceleration = angle.rate[:, None], angle.acceleration[:, None]
    return p, dp * rate, ddp * rate**2 + dp * acceleration
