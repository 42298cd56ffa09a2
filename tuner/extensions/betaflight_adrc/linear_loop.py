"""The sampled rate loop in the z-domain: frequency response, crossovers and margins.

    L(z) = C(z) F(z) P(z),   C from y_f to -u with u of the loop before fed back, F the gyro's filters, P held over a period:

    P(s) = b_acc (1 + T_z s) e^{-L s}/(s (1 + tau s)),   T_z > 0 for yaw alone, from the reaction torque of the rotors

P(z) is exact for any dead time L (K. J. Astrom and B. Wittenmark, Computer-Controlled Systems, 3rd ed., section 2.3): with d
whole periods in L rounded up, delta = d T - L and a = e^{-T/tau},

    P(z) = b_acc z^-d [T/(z - 1) + delta + T_z - tau - (T_z - tau) e^{-delta/tau} (z - 1)/(z - a)]

A gain margin is read where the phase falls through -180 deg: the loop rings there if its own gain is larger by that factor.
"""

from dataclasses import dataclass, replace
from math import ceil, exp, pi, remainder
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.laws.filters import stage_share
from tuner.extensions.betaflight_adrc.equations import AxisConstants, damping_gain
from tuner.extensions.betaflight_adrc.settings import Tune

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
MIN_FREQUENCY = 0.5
"""Lowest frequency of a margin [Hz]; below it the leak of z3 decides."""
N_FREQUENCIES = 1200
HALF_RATE = 0.49
"""Highest frequency over the rate of the loop."""


@dataclass(frozen=True)
class AxisPlant:
    """The plant of an axis, from its output to the rate.

    Attributes:
        gain: Acceleration gain b_acc [deg/s2] per unit of output.
        lag: Motor lag tau [s].
        dead_time: Dead time L [s].
        zero: Time constant T_z of the zero [s], 0 for none.
    """

    gain: float
    lag: float
    dead_time: float
    zero: float = 0.0

    @property
    def b0(self) -> float:
        """Gain from the output to rate'' at high frequency without the zero [deg/s3]."""
        return self.gain / self.lag

    @classmethod
    def identified(cls, gain: float, lag: float, delay: float, period: float, zero: float = 0.0) -> "AxisPlant":
        """Return the plant of a fit to logged outputs.

        Its delay [s] contains half a period of the hold.
        """
        return cls(gain, lag, max(delay - 0.5 * period, 0.0), zero)


@dataclass(frozen=True)
class Sampling:
    """Rates and filters ahead of the observer.

    Attributes:
        period: Period of the PID loop [s].
        gyro_period: Period of the gyro and of its low-passes [s].
        cutoffs: First-order low-passes of the gyro [Hz].
    """

    period: float = 125e-6
    gyro_period: float = 125e-6
    cutoffs: tuple[float, ...] = (250.0, 500.0)


class Margins(NamedTuple):
    """Margins of a loop.

    gain: factor to the gain that rings, below 1 where the loop rings already; ring: frequency there [Hz]; phase [rad]; crossover:
    frequency of the phase margin [Hz]. NaN where there is no crossing.
    """

    gain: float
    ring: float
    phase: float
    crossover: float


def controller_response(
    constants: AxisConstants, scale: float, is_open: bool, z: ComplexArray, period: float
) -> ComplexArray:
    """Return C at points z; on the ground z3 does not grow, so its row is empty, and wc is that of the ground."""
    t, wo, b = period, constants.wo, constants.b0 * scale
    wc = constants.wc if is_open else constants.ground_wc
    leak = constants.leak if is_open else 0.0
    model = np.array([[1.0, t, 0.0], [0.0, 1.0 - t * constants.inverse_tau, t], [0.0, 0.0, 1.0 - t * leak]])
    injection = t * np.array([3.0 * wo, 3.0 * wo**2, wo**3 if is_open else 0.0])
    law = np.array([wc**2, damping_gain(wc, constants), 1.0]) / b
    model = model - np.outer(injection, [1.0, 0.0, 0.0])
    if is_open:
        model = model - np.outer([0.0, t * b, 0.0], law)
    else:
        model[1, 2] = 0.0
    states = np.linalg.solve(z[:, None, None] * np.eye(3) - model, (injection * z[:, None])[:, :, None])
    return states[:, :, 0] @ law


def stage_response(share: float, z: ComplexArray) -> ComplexArray:
    """Return the response of a first-order stage at points z."""
    return share / (1.0 - (1.0 - share) / z)


def filter_response(constants: AxisConstants, sampling: Sampling, frequency: Array) -> ComplexArray:
    """Return the response of all filters of the gyro at frequencies [Hz]."""
    z_gyro, z = (np.exp(2j * pi * frequency * t) for t in (sampling.gyro_period, sampling.period))
    response = stage_response(constants.share, z) ** 2
    for cutoff in sampling.cutoffs:
        response = response * stage_response(stage_share(cutoff, sampling.gyro_period), z_gyro)
    return response


def plant_response(plant: AxisPlant, z: ComplexArray, period: float) -> ComplexArray:
    """Return the response of the held plant at points z."""
    periods = ceil(plant.dead_time / period - 1e-9)
    delta, tail = periods * period - plant.dead_time, plant.zero - plant.lag
    decay = np.exp(-period / plant.lag)
    step = period / (z - 1.0) + delta + tail - tail * np.exp(-delta / plant.lag) * (z - 1.0) / (z - decay)
    return plant.gain * step / z**periods


def loop_response(
    tune: Tune,
    axis: str,
    plant: AxisPlant,
    sampling: Sampling,
    frequency: Array,
    scale: float = 1.0,
    is_open: bool = True,
) -> ComplexArray:
    """Return L of an axis at frequencies [Hz]; scale: of b0."""
    constants = tune.axis(axis, sampling.period)
    z = np.exp(2j * pi * frequency * sampling.period)
    response = controller_response(constants, scale, is_open, z, sampling.period)
    return response * filter_response(constants, sampling, frequency) * plant_response(plant, z, sampling.period)


def margins(
    tune: Tune, axis: str, plant: AxisPlant, sampling: Sampling, scale: float = 1.0, is_open: bool = True
) -> Margins:
    """Return the margins of an axis; of several crossings the worst.

    Args:
        tune: Settings.
        axis: Name of the axis.
        plant: Plant of the axis.
        sampling: Rates and filters.
        scale: Scale of b0.
        is_open: Whether the gate is open.
    """
    frequency = np.geomspace(MIN_FREQUENCY, HALF_RATE / sampling.period, N_FREQUENCIES)
    response = loop_response(tune, axis, plant, sampling, frequency, scale, is_open)
    place, size, phase = np.log(frequency), np.log(np.abs(response)), np.unwrap(np.angle(response))
    turns = np.floor((phase + pi) / (2.0 * pi))
    falls = np.flatnonzero(turns[1:] < turns[:-1])
    rings = _zeros(phase + pi, 2.0 * pi * turns[falls], falls, size, place)
    crossings = _zeros(size, 0.0, np.flatnonzero(size[1:] * size[:-1] < 0.0), phase, place)
    nowhere = (float("nan"), float("nan"))
    gains = [(exp(-level), exp(at)) for level, at in rings]
    phases = [(remainder(angle + pi, 2.0 * pi), exp(at)) for angle, at in crossings]
    return Margins(*min(gains, default=nowhere), *min(phases, default=nowhere))


def _zeros(values: Array, level: Array | float, places: NDArray[np.intp], *others: Array) -> list[list[float]]:
    """Return other series where one meets a level, behind places (n,)."""
    low, high = values[places], values[places + 1]
    share = (level - low) / (high - low)
    return np.column_stack(
        [series[places] + share * (series[places + 1] - series[places]) for series in others]
    ).tolist()


def scaled(plant: AxisPlant, factor: float) -> AxisPlant:
    """Return the plant with another gain."""
    return replace(plant, gain=factor * plant.gain)
