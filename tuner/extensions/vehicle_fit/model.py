"""The vehicle as the logs see it: motor commands to rotors that lag, thrusts, angular acceleration and lift.

A rotor's speed is its command after a lag, up and down of its own, times the speed at full command; the thrust curve takes
the lagging command, as the plant's square law takes the speed. The body turns as in `rigid_body.py`; what air does to it is
left to the noise.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.vehicle_fit.parameters import PhysicalParameters
from tuner.extensions.vehicle_fit.recursions import TurnedBody, lag_windows, turn_body
from tuner.extensions.vehicle_fit.samples import LogSegment, model_outputs

Array = NDArray[np.float64]

# Rotors run in over so many of the longest time constants, and at most so long [s]; windows last [s].
RUN_IN, LONGEST_RUN_IN, WINDOW = 8.0, 1.0, 0.4

# Decay of the climb over a piece that is worked out at once, in exponents.
LONGEST_DECAY = 5.0


class Actuator(NamedTuple):
    """Time constants and dead time of the rotors [s]."""

    lag_up: float
    lag_down: float
    dead_time: float


def actuator(numbers: PhysicalParameters) -> Actuator:
    """Return the actuator of a point."""
    return Actuator(numbers.lag_up, numbers.lag_down, numbers.dead_time)


def lagging(samples: LogSegment, actuators: Sequence[Actuator]) -> list[Array]:
    """Return the lagging commands (n, 4) of a stretch for each actuator.

    The stretch is cut into windows, each run in from the commands before it.
    """
    period = samples.period
    longest = max(max(entry.lag_up, entry.lag_down) for entry in actuators)
    before = int(np.ceil(min(RUN_IN * longest, LONGEST_RUN_IN) / period))
    width = max(int(WINDOW / period), 1)
    shares = -np.expm1(-period / np.array([(entry.lag_up, entry.lag_down) for entry in actuators]))
    return [
        lag_windows(samples.command, entry.dead_time / period, before, width, rise, fall)
        for entry, (rise, fall) in zip(actuators, shares.tolist(), strict=True)
    ]


def turning(samples: LogSegment, lagged: Array, numbers: PhysicalParameters, vehicle: Vehicle) -> tuple[Array, Array]:
    """Return angular acceleration (n, 3) [rad/s2] and lift (n,) [m/s2] of a segment."""
    body = TurnedBody(
        numbers.curve,
        float(np.sqrt(numbers.thrust[-1] / vehicle.thrust_coefficient)),
        numbers.arm * np.array(vehicle.rotor_x) - numbers.center[0],
        numbers.arm * np.array(vehicle.rotor_y) - numbers.center[1],
        np.array(vehicle.spin),
        numbers.torque_ratio,
        numbers.rotor * vehicle.rotor_inertia,
        np.array(numbers.inertia),
        numbers.rate_damping,
        float(numbers.yaw_bias[samples.log]),
    )
    left = 1.0 - numbers.sag[samples.log] * samples.age
    turned, thrust = turn_body(body, lagged, samples.gyro, left, samples.period)
    lift = climbing(thrust / numbers.mass, samples.period, numbers.climb_drag / numbers.mass)
    return turned, lift + numbers.lift_bias[samples.log]


def climbing(lift: Array, period: float, rate: float) -> Array:
    """Return the lift (n,) less the drag of its climb: v' = lift - mean - rate v, from rest; rate [1/s].

    Level flight is assumed, so what tilt takes away is in the mean.
    """
    keep = np.exp(-rate * period)
    push, climb, speed = (lift - lift.mean()) * (1.0 - keep), np.empty_like(lift), 0.0
    # In pieces over which the powers of `keep` stay in range.
    width = max(int(min(LONGEST_DECAY / (rate * period), len(lift))), 1)
    powers = keep ** np.arange(1, width + 1)
    for first in range(0, len(lift), width):
        part = push[first : first + width]
        decay = powers[: len(part)]
        run = decay * (speed + np.cumsum(part / decay))
        climb[first : first + width] = run
        speed = run[-1]
    return lift - climb


def predicted(samples: LogSegment, lagged: Array, numbers: PhysicalParameters, vehicle: Vehicle) -> Array:
    """Return the outputs (m, 4) of the model."""
    turned, lift = turning(samples, lagged, numbers, vehicle)
    steps = 0.5 * samples.period * (turned[1:] + turned[:-1])
    rates = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    return model_outputs(low_passed(rates, samples.period, numbers.gyro_delay), lift, samples.share)


def low_passed(rates: Array, period: float, delay: float) -> Array:
    """Return rates (n, 3), from 0, behind a Butterworth low-pass of second order; delay: its own at low frequencies [s].

    Exact for rates that are straight lines between samples.
    """
    from scipy.signal import lfilter

    return np.asarray(lfilter(*_ramp_invariant(period, delay), rates, axis=0), np.float64)


@lru_cache(maxsize=64)
def _ramp_invariant(period: float, delay: float) -> tuple[Array, Array]:
    """Return numerator and denominator of the low-pass in z.

    The ramp t becomes t - d + d exp(-s t) cos(s t), with d the delay and s = 1 / d: both parts of the poles. A closed form,
    because a fit has as many delays as points, and SciPy takes longer for one than the flight takes through the model.
    """
    turn, share = period / delay, delay / period
    cosine, decay = np.exp(-turn) * np.cos(turn), np.exp(-2.0 * turn)
    numerator = [
        1.0 - share * (1.0 - cosine),
        share * (1.0 - decay) - 2.0 * cosine,
        decay - share * (cosine - decay),
    ]
    return np.array(numerator), np.array([1.0, -2.0 * cosine, decay])
