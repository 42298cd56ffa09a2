"""Sensors: the true state plus noise and bias that were drawn before the flight."""

from dataclasses import dataclass, fields
from math import isfinite
from typing import NamedTuple

import numpy as np

from plant.errors import InputError
from plant.quadrotor.attitude import heading_direction, thrust_direction
from plant.quadrotor.rigid_body import Body
from plant.vectors import Vec3, axpy3, to_world

NOISE_ROWS = 12


class Noise(NamedTuple):
    """Sensor errors of one control instant: position [m], velocity [m/s] in world ENU; angles: roll, pitch, yaw [rad]; rate:
    gyro, body FLU [rad/s].
    """

    position: Vec3
    velocity: Vec3
    angles: Vec3
    rate: Vec3


class Measurement(NamedTuple):
    """The plant as measured.

    Attributes:
        position [m], velocity [m/s]: in world ENU.
        angles: roll, pitch, yaw [rad].
        rate: body FLU [rad/s].
        thrust_direction: body z axis in world coordinates.
        heading: (cos yaw, sin yaw, 0).
    """

    position: Vec3
    velocity: Vec3
    angles: Vec3
    rate: Vec3
    thrust_direction: Vec3
    heading: Vec3


def measure(body: Body, angles: Vec3, rate: Vec3, noise: Noise) -> Measurement:
    """Add the sensor errors to the true state; angles: its roll, pitch, yaw [rad]; rate: body rate at the gyro [rad/s].

    The angle errors turn the two directions to first order. At 2 mrad and level, that leaves both right to 1e-5; leaning by t,
    the thrust direction takes yaw and roll errors as if level, which is off by some 2 mrad times sin t.
    """
    q, n = body.attitude, noise.angles
    ahead = to_world(q, Vec3(n.y, -n.x, 0.0))
    heading = heading_direction(q)
    return Measurement(
        axpy3(body.position, 1.0, noise.position),
        axpy3(body.velocity, 1.0, noise.velocity),
        axpy3(angles, 1.0, n),
        axpy3(rate, 1.0, noise.rate),
        axpy3(thrust_direction(q), 1.0, ahead),
        Vec3(heading.x - n.z * heading.y, heading.y + n.z * heading.x, 0.0),
    )


@dataclass(frozen=True)
class SensorSpec:
    """RMS of white noise and of the flight's bias, by sensor axis.

    position [m], velocity [m/s], attitude [rad], rate [rad/s]; the same four for the bias. The defaults are small: they are
    there so that a high observer bandwidth costs control activity (facts of a 2 mrad attitude filter and a MEMS gyro).
    """

    position: float = 0.002
    velocity: float = 0.01
    attitude: float = 0.002
    rate: float = 0.01
    position_bias: float = 0.0
    velocity_bias: float = 0.0
    attitude_bias: float = 0.0
    rate_bias: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (isfinite(value) and value >= 0.0):
                raise InputError(f"given {value}; an RMS value must be finite and not negative", key=field.name)

    def silent(self) -> bool:
        """Return True if every noise and bias is zero."""
        return not any(getattr(self, field.name) for field in fields(self))


def draw_noise(spec: SensorSpec, generator: np.random.Generator, out: np.ndarray) -> None:
    """Draw the sensor errors of one flight into float64 (steps, 12), columns in the leaf order of `Noise`.

    Everything is drawn at unit size and then scaled, so switching one sensor's noise off leaves the others' bits alone.
    """
    white = np.repeat([spec.position, spec.velocity, spec.attitude, spec.rate], 3)
    bias = np.repeat([spec.position_bias, spec.velocity_bias, spec.attitude_bias, spec.rate_bias], 3)
    offset = bias * generator.standard_normal(NOISE_ROWS)
    np.multiply(generator.standard_normal(out.shape), white, out=out)
    out += offset
