"""Classical margins of one loop, from the crossings of its curve T.

They are gain, phase and delay margin and the crossover frequency; `curve` has T.
With L = -T/(1 + T): L is real and negative where T is real and above 0 or below -1, and k L passes -1 at k = (1 + T)/T.
|L| = 1 where Re T = -1/2, and there arg L = -2 atan(2 Im T). All crossings count, since conditionally stable loops have several:
the gain of a loop with integral action on a double integrator must neither rise nor fall too far.

Valid for stable closed loops. No crossing gives an infinite margin.
"""

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Gain factors beyond 50 dB count as none: at the ends of the curve, where T is 0 or -1, rounding makes up crossings of 140 dB,
# and a factor of 461 (53 dB) differed by 1e-5 between processors.
MAX_GAIN_DB = 50.0
MAX_GAIN = 10.0 ** (MAX_GAIN_DB / 20.0)

FIELDS = ("gain_up", "gain_down", "phase", "delay", "crossover")
"""Fields of `Margins` that are read here."""


class MarginAt(NamedTuple):
    """A margin and its frequency [rad/s], arrays of one shape.

    The frequency is that at which the margin is met, 0 where the margin is infinite.
    """

    value: Array
    frequency: Array


def _least(candidates: Array, frequency: Array) -> MarginAt:
    """Least along the last axis, with its frequency; infinite ones and NaN do not count."""
    finite = np.where(np.isfinite(candidates), candidates, np.inf).reshape(-1, candidates.shape[-1])
    rows, at = np.arange(len(finite)), np.argmin(finite, axis=-1)
    value = finite[rows, at]
    at_value = np.where(np.isfinite(value), frequency.reshape(finite.shape)[rows, at], 0.0)
    return MarginAt(value.reshape(candidates.shape[:-1]), at_value.reshape(candidates.shape[:-1]))


def read(real: Array, line: Array, requested: Collection[str] = FIELDS) -> dict[str, MarginAt]:
    """Return the requested classical margins, by field of `Margins`.

    real, line: crossings (..., n, 2) where T is real and where Re T = -1/2.
    """
    real, line, margins = _used(real), _used(line), dict[str, MarginAt]()
    if "gain_up" in requested or "gain_down" in requested:
        margins["gain_up"], margins["gain_down"] = gain_margins(real)
    if "phase" in requested:
        margins["phase"] = phase_margin(line)
    if "delay" in requested:
        margins["delay"] = delay_margin(line)
    if "crossover" in requested:
        highest = crossover(line)
        margins["crossover"] = MarginAt(highest, highest)
    return margins


def _used(crossings: Array) -> Array:
    """Return crossings (..., n, 2) without the unused rows at the end.

    No loop of the batch uses those; at least one row stays.
    """
    most = int(np.max(np.sum(crossings[..., 0] == crossings[..., 0], axis=-1), initial=1))
    return crossings[..., :most, :]


def gain_margins(real: Array) -> tuple[MarginAt, MarginAt]:
    """Return the factors (...) by which the loop gain may rise or fall.

    Both are 1 or more.
    real (..., n, 2): w and T where T is real, NaN in spare rows.
    """
    w, t = real[..., 0], real[..., 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        rise = np.where(t > 0.0, (1.0 + t) / t, np.inf)
        fall = np.where(t < -1.0, t / (1.0 + t), np.inf)
    return _least(np.where(rise < MAX_GAIN, rise, np.inf), w), _least(np.where(fall < MAX_GAIN, fall, np.inf), w)


def phase_margin(line: Array) -> MarginAt:
    """Return the least angle [rad] between L and -1 where |L| = 1.

    It is a lag or a lead. line (..., n, 2): w and Im T where Re T = -1/2.
    """
    return _least(np.pi - 2.0 * np.arctan(2.0 * np.abs(line[..., 1])), line[..., 0])


def delay_margin(line: Array) -> MarginAt:
    """Least delay [s] that brings L to -1: at each crossing the lag, 0 to 2 pi, over the frequency."""
    w = line[..., 0]
    return _least((np.pi - 2.0 * np.arctan(2.0 * line[..., 1])) / np.where(w > 0.0, w, np.nan), w)


def crossover(line: Array) -> Array:
    """Highest frequency [rad/s] at which |L| = 1; 0 where there is none."""
    return np.max(np.nan_to_num(line[..., 0]), axis=-1)
