"""The gyro: the body's rate through a mode of the frame, lines of the turning rotors, and the gyro's own low-pass.

    heard = L(M(rate)) + sum over rotors i and n = 1, 2, 3 of |L(n w_i)| a_n (w_i/w_hover)^2 (forces that turn n times a turn)

M = 1 + g s^2/(s^2 + 2 z w s + w^2) is a mode of the frame that the body's angular acceleration drives and the gyro picks up; L
is a Butterworth low-pass of second order. Both are sampled with the control period and stand in flights and margins alike.
Lines are heard as they are sampled: one above half the control rate folds down, weakened by L alone. Parts that the airframe's
file lacks are absent in the loop.

M is one mode next to the rigid body in modal form, W. K. Gawronski, Advanced Structural Dynamics and Active Control of
Structures, 2004, chapter 2: g is -1 for a gyro on a hub whose arms carry the rotors on a spring, positive where both move alike.
"""

from collections.abc import Callable
from math import pi
from typing import Any, NamedTuple

from plant.laws.filters import (
    PI,
    Delays,
    Section,
    low_pass,
    mode,
    settled_section,
    step_section,
)
from plant.primitives import cos, floor, sin, sqrt
from plant.quadrotor.rigid_body import Body
from plant.quadrotor.sensors import Noise
from plant.quadrotor.vehicle import Vehicle
from plant.records import record_type
from plant.vectors import Rotors, Vec3, axpy3

HARMONICS = 3
TURNS = 4
"""Columns that the drawn turns of the rotors take behind the sensor errors of an instant."""


class Lines(NamedTuple):
    """Amplitude at the gyro of the first three harmonics of a rotor, over its squared speed [s/rad]."""

    first: float
    second: float
    third: float


class GyroPath(NamedTuple):
    """The way from the body's rate to its samples, as kernels read it; slowness: 1/(2 pi cut-off) of its low-pass [s]."""

    lines: Lines
    slowness: float
    low_pass: Section
    mode: Section


class Filtered(NamedTuple):
    """Memory of a section, for each body axis."""

    x: Delays
    y: Delays
    z: Delays


class NoiseAndTurns(NamedTuple):
    """Sensor errors of an instant as in `Noise`, and what each rotor had turned when the flight began [turns]."""

    position: Vec3
    velocity: Vec3
    angles: Vec3
    rate: Vec3
    turned: Rotors


class NoState(NamedTuple):
    """Memory of a part that is not there."""


class Gyro(NamedTuple):
    """A gyro as model functions.

    Memory: type of its state. Noise: type of the errors of an instant that it takes. start(body, nominal) -> Memory at rest.
    hear(memory, body, noise, nominal, h) -> (rate [rad/s] to which its errors add, Memory).
    """

    Memory: Any
    Noise: Any
    start: Callable[..., Any]
    hear: Callable[..., Any]


def gyro_path(vehicle: Vehicle, control_period: float) -> GyroPath:
    """Return the gyro path of a vehicle at a control period [s]."""
    hover = 0.25 * vehicle.mass * vehicle.gravity / vehicle.thrust_coefficient
    cutoff = vehicle.gyro_cutoff
    return GyroPath(
        Lines(vehicle.vibration_1 / hover, vehicle.vibration_2 / hover, vehicle.vibration_3 / hover),
        0.5 / (pi * cutoff) if cutoff > 0.0 else 0.0,
        low_pass(cutoff, control_period),
        mode(vehicle.mode_frequency, vehicle.mode_damping, vehicle.mode_gain, control_period),
    )


def rotor_lines(turns: float, speed: float, spin: float, x: float, y: float, path: GyroPath) -> Vec3:
    """Rate [rad/s] about the body axes that the lines of one rotor add.

    A force that turns with the rotor, at its place, bends the frame: roll hears its part to the left, pitch that ahead, yaw what
    goes round the middle. turns: that the rotor has made; speed [rad/s]; x, y: its place [m].
    """
    angle = 2.0 * PI * turns
    s, c = sin(angle), cos(angle)
    square, slow = speed * speed, path.slowness * speed
    first = path.lines.first * square * passed(slow)
    second = path.lines.second * square * passed(2.0 * slow)
    third = path.lines.third * square * passed(3.0 * slow)
    ahead = first * c + second * (1.0 - 2.0 * s * s) + third * c * (4.0 * c * c - 3.0)
    left = -spin * (first * s + second * 2.0 * s * c + third * s * (3.0 - 4.0 * s * s))
    return Vec3(-left, ahead, (x * left - y * ahead) / sqrt(x * x + y * y))


def passed(ratio: float) -> float:
    """Share that a Butterworth low-pass of second order lets through of an oscillation of frequency over cut-off `ratio`."""
    square = ratio * ratio
    return 1.0 / sqrt(1.0 + square * square)


def all_lines(turned: Rotors, speed: Rotors, vehicle: Vehicle, path: GyroPath) -> Vec3:
    """Rate [rad/s] about the body axes that the lines of all rotors add."""
    x, y, spin = vehicle.rotor_x, vehicle.rotor_y, vehicle.spin
    one = rotor_lines(turned.r1, speed.r1, spin.r1, x.r1, y.r1, path)
    two = rotor_lines(turned.r2, speed.r2, spin.r2, x.r2, y.r2, path)
    three = rotor_lines(turned.r3, speed.r3, spin.r3, x.r3, y.r3, path)
    four = rotor_lines(turned.r4, speed.r4, spin.r4, x.r4, y.r4, path)
    return axpy3(axpy3(one, 1.0, two), 1.0, axpy3(three, 1.0, four))


def turned_on(turns: float, speed: float, h: float) -> float:
    """Return the turns of a rotor a period h [s] later, modulo 1."""
    later = turns + speed * h / (2.0 * PI)
    return later - floor(later)


def vibration_start() -> Rotors:
    """Turns since the flight began."""
    return Rotors(0.0, 0.0, 0.0, 0.0)


def vibrate(
    turns: Rotors, rate: Vec3, speed: Rotors, noise: NoiseAndTurns, nominal: Any, h: float
) -> tuple[Vec3, Rotors]:
    """Add the lines of the rotors to a rate; return it and the turns [1] a period h [s] later."""
    drawn = noise.turned
    turned = Rotors(turns.r1 + drawn.r1, turns.r2 + drawn.r2, turns.r3 + drawn.r3, turns.r4 + drawn.r4)
    heard = axpy3(rate, 1.0, all_lines(turned, speed, nominal.vehicle, nominal.gyro))
    return heard, Rotors(
        turned_on(turns.r1, speed.r1, h),
        turned_on(turns.r2, speed.r2, h),
        turned_on(turns.r3, speed.r3, h),
        turned_on(turns.r4, speed.r4, h),
    )


def keep_nothing() -> NoState:
    """Keep nothing."""
    return NoState()


def unshaken(
    turns: NoState,
    rate: Vec3,
    speed: Rotors,
    noise: Noise,
    nominal: Any,
    h: float,  # noqa: ARG001
) -> tuple[Vec3, NoState]:
    """Leave a rate as it is."""
    return rate, turns


def filter_start(rate: Vec3, section: Section) -> Filtered:
    """Memory of a section that a constant rate has gone through for long."""
    return Filtered(
        settled_section(rate.x, section), settled_section(rate.y, section), settled_section(rate.z, section)
    )


def filter_rate(state: Filtered, rate: Vec3, section: Section) -> tuple[Vec3, Filtered]:
    """A rate behind a section, axis by axis, and what it keeps."""
    x, kept_x = step_section(state.x, rate.x, section)
    y, kept_y = step_section(state.y, rate.y, section)
    z, kept_z = step_section(state.z, rate.z, section)
    return Vec3(x, y, z), Filtered(kept_x, kept_y, kept_z)


def through_start(rate: Vec3, section: Section) -> NoState:  # noqa: ARG001
    """Keep nothing."""
    return NoState()


def through(state: NoState, rate: Vec3, section: Section) -> tuple[Vec3, NoState]:  # noqa: ARG001
    """Leave a rate as it is."""
    return rate, state


def gyro_of(*, has_vibration: bool, has_flexible_mode: bool, has_low_pass: bool) -> Gyro:
    """Return the gyro with rotor lines, a frame mode and a low-pass, as chosen."""
    turns, turns_start, shake = (
        (Rotors, vibration_start, vibrate) if has_vibration else (NoState, keep_nothing, unshaken)
    )
    absent, present = (NoState, through_start, through), (Filtered, filter_start, filter_rate)
    Bent, mode_start, bend = present if has_flexible_mode else absent
    Smoothed, smooth_start, smooth = present if has_low_pass else absent
    Memory = record_type("GyroMemory", {"turns": turns, "mode": Bent, "low_pass": Smoothed})

    def start(body: Body, nominal: Any) -> Any:
        path = nominal.gyro
        return Memory(turns_start(), mode_start(body.rate, path.mode), smooth_start(body.rate, path.low_pass))

    def hear(state: Any, body: Body, noise: Any, nominal: Any, h: float) -> Any:
        path = nominal.gyro
        bent, flexed = bend(state.mode, body.rate, path.mode)
        smoothed, passing = smooth(state.low_pass, bent, path.low_pass)
        heard, later = shake(state.turns, smoothed, body.rotor_speed, noise, nominal, h)
        return heard, Memory(later, flexed, passing)

    return Gyro(Memory, NoiseAndTurns if has_vibration else Noise, start, hear)
