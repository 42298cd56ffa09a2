"""Compiled loops over the samples of a log: rotors that lag, and the body that they turn.

Without `fastmath`: every operation rounds by itself, in the order of the source.
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.backends.cache import keep_file
from plant.backends.compiling import inliner, kernel

Array = NDArray[np.float64]


class TurnedBody(NamedTuple):
    """A body that rotors turn, SI units.

    Attributes:
        curve: Coefficients (3,) of a rotor's thrust over its lagging command: constant, linear, quadratic.
        full_speed: Speed of a rotor at full command.
        x: Positions (4,) of the rotors.
        y: Positions (4,) of the rotors.
        spin: Directions (4,) of the reaction torques, 1 or -1.
        torque_ratio: Torque over thrust of a rotor.
        rotor_inertia: Inertia of a rotor.
        inertia: Inertias (3,) about x, y and z.
        damping: Torque over rate, about x and y.
        yaw_bias: Constant torque about z.
    """

    curve: Array
    full_speed: float
    x: Array
    y: Array
    spin: Array
    torque_ratio: float
    rotor_inertia: float
    inertia: Array
    damping: float
    yaw_bias: float


def lag_windows(commands: Array, delay: float, before: int, width: int, rise: float, fall: float) -> Array:
    """Return delayed commands (n, 4) behind lags, in windows that are each run in.

    Args:
        commands: Commands (n, 4), held at both ends.
        delay: Delay in samples, between which commands are linearly interpolated.
        before: Number of samples that a window is run in over.
        width: Number of samples of a window.
        rise: Share of a gap that a sample closes upwards.
        fall: Share of a gap that a sample closes downwards.
    """
    n, n_samples = len(commands), math.floor(delay)
    share = delay - n_samples
    late, lagged, state = np.empty((n, 4)), np.empty((n, 4)), np.empty(4)
    for k in range(n):
        at, earlier = min(max(k - n_samples, 0), n - 1), min(max(k - n_samples - 1, 0), n - 1)
        for i in range(4):
            late[k, i] = (1.0 - share) * commands[at, i] + share * commands[earlier, i]
    for first in range(0, n, width):
        begin = max(first - before, 0)
        # Element by element: numba takes 2 s to compile the copy of a row.
        for i in range(4):
            state[i] = late[begin, i]
        for k in range(begin, min(first + width, n)):
            for i in range(4):
                if k >= first:
                    lagged[k, i] = state[i]
                gap = late[k, i] - state[i]
                state[i] += gap * (rise if gap > 0.0 else fall)
    return lagged


@inliner({})
def weighted_sum(weights: Array, values: Array) -> float:
    """Return the sum of 4 values, each times its weight: in the order in which BLAS adds them."""
    return (weights[0] * values[0] + weights[2] * values[2]) + (weights[1] * values[1] + weights[3] * values[3])


def turn_body(body: TurnedBody, lagged: Array, rates: Array, left: Array, period: float) -> tuple[Array, Array]:
    """Return angular accelerations (n, 3) [rad/s2] and the sums of the thrusts (n,) [N].

    Args:
        body: The body and its rotors.
        lagged: Lagging commands (n, 4).
        rates: Body rates (n, 3) [rad/s].
        left: Share of the thrust (n,) that is left.
        period: Time from sample to sample [s].
    """
    n, (ix, iy, iz) = len(lagged), body.inertia
    turned, lift = np.empty((n, 3)), np.empty(n)
    thrust, speed, faster = np.empty(4), np.empty(4), np.empty(4)
    for k in range(n):
        before, after = max(k - 1, 0), min(k + 1, n - 1)
        for i in range(4):
            command = lagged[k, i]
            thrust[i] = (body.curve[0] + command * (body.curve[1] + command * body.curve[2])) * left[k]
            speed[i] = command * body.full_speed
            rise = lagged[after, i] * body.full_speed - lagged[before, i] * body.full_speed
            faster[i] = rise / ((after - before) * period)
        p, q, r = rates[k, 0], rates[k, 1], rates[k, 2]
        momentum = -body.rotor_inertia * weighted_sum(body.spin, speed)
        spun = body.rotor_inertia * weighted_sum(body.spin, faster)
        roll = weighted_sum(body.y, thrust) - q * momentum - (iz - iy) * q * r - body.damping * p
        pitch = -weighted_sum(body.x, thrust) + p * momentum - (ix - iz) * r * p - body.damping * q
        yaw = body.torque_ratio * weighted_sum(body.spin, thrust) + spun - (iy - ix) * p * q + body.yaw_bias
        turned[k, 0], turned[k, 1], turned[k, 2] = roll / ix, pitch / iy, yaw / iz
        lift[k] = thrust[0] + thrust[1] + thrust[2] + thrust[3]
    return turned, lift


lag_windows = keep_file(kernel({})(lag_windows), Path(__file__))
turn_body = keep_file(kernel({"error_model": "numpy"})(turn_body), Path(__file__))
