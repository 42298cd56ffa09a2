"""Frequency responses of a fitted model: from the motor commands, mixed by axis, to body rates and lift.

The command of an axis is its row of the mixer over the sum of the row's sizes, so a command of 1 is full command of all motors,
each with the sign of its lever. The thrust curve is taken by its slope at the mean command, the lags up and down by the mean of
their rates. Rates are seen behind the gyro's low-pass.
"""

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.nominal import mixer_matrix
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.vehicle_fit.fit import DIFFERENCE_STEP
from tuner.extensions.vehicle_fit.parameters import ParameterSpace, PhysicalParameters

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def axis_commands(vehicle: Vehicle, command: Array) -> Array:
    """Return the commands (n, 4) of roll, pitch, yaw and lift: of those of the motors (n, 4)."""
    mixer = mixer_matrix(vehicle)[[1, 2, 3, 0]]
    return command @ (mixer / np.abs(mixer).sum(axis=1, keepdims=True)).T


def model_response(
    numbers: PhysicalParameters, vehicle: Vehicle, operating_point: float, frequency: Array, period: float
) -> ComplexArray:
    """Return the responses (f, 4) of rates [rad/s] and lift [m/s2].

    Args:
        numbers: Physical parameters of the vehicle.
        vehicle: Airframe whose levers the commands are mixed by.
        operating_point: Mean command of the motors.
        frequency: Frequencies (f,) [Hz].
        period: Time that a command is held [s].
    """
    s = 2j * np.pi * frequency
    slope = (numbers.curve[1] + 2.0 * operating_point * numbers.curve[2]) * (1.0 - 0.5 * float(np.mean(numbers.sag)))
    lag = 2.0 / (1.0 / numbers.lag_up + 1.0 / numbers.lag_down)
    held = -np.expm1(-s * period) / (s * period)
    rotor = np.exp(-s * numbers.dead_time) / (1.0 + lag * s) * held
    x, y = (numbers.arm * float(np.abs(np.array(places)).sum()) for places in (vehicle.rotor_x, vehicle.rotor_y))
    speed = np.sqrt(numbers.thrust[-1] / vehicle.thrust_coefficient)
    reaction = numbers.rotor * vehicle.rotor_inertia * speed * s
    inertia, rate = numbers.inertia, numbers.climb_drag / numbers.mass
    # The low-pass of `model.low_passed` in continuous time; its delay is sqrt(2) over the cut-off in rad/s.
    late = s * numbers.gyro_delay
    sensed = rotor / (1.0 + late + 0.5 * late**2)
    return np.column_stack(
        [
            sensed * slope * y / (inertia.x * s + numbers.rate_damping),
            sensed * slope * x / (inertia.y * s + numbers.rate_damping),
            sensed * 4.0 * (numbers.torque_ratio * slope + reaction) / (inertia.z * s),
            rotor * 4.0 * slope / numbers.mass * s / (s + rate),
        ]
    )


def response_deviation(
    space: ParameterSpace, point: Array, covariance: Array, setting: tuple[Vehicle, float, Array, float]
) -> tuple[Array, Array]:
    """Return standard deviations (f, 4) of the magnitude, relative, and of the phase [rad]: to first order.

    Args:
        space: Coordinates of the model.
        point: Estimate of them.
        covariance: Covariance of the estimate.
        setting: Arguments of `model_response` behind the numbers.
    """
    center = model_response(space.numbers(point), *setting)
    steps = DIFFERENCE_STEP * space.prior_std
    moved = [space.numbers(point + steps[k] * (np.arange(len(point)) == k)) for k in range(len(point))]
    slopes = np.stack([np.log(model_response(entry, *setting) / center) for entry in moved], axis=-1) / steps
    magnitude, phase = (
        np.sqrt(np.einsum("fka,ab,fkb->fk", part, covariance, part)) for part in (slopes.real, slopes.imag)
    )
    return magnitude, phase
