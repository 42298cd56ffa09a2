"""Thrust curve of a rotor over its motor command.

    T = T_max ((1 - a) u^2 + a u)
    w^2 = w_c ((1 - a) w_c + a w_max),    w_c = u w_max

A speed controller (ESC) that is commanded w_c holds w. With a = 0 command and speed are proportional. The controller asks for
thrust and inverts the curve of the nominal vehicle, so a vehicle with that curve answers with unit gain; one with another a
answers with the quotient of both slopes at hover. Below 0 the curve is cut: a rotor with a < 0 stands still up to u = -a/(1 - a).

It is the curve of PX4, whose THR_MDL_FAC is 1 - a. PX4 parameter reference, 1.16:
"rel_thrust = factor * rel_signal^2 + (1-factor) * rel_signal".
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from plant.primitives import maximum, select, sqrt
from plant.vectors import Rotors

MIN_LINEAR, MAX_LINEAR = -1.0, 1.0
"""Ends of the range of a, the first outside of it: thrust never falls with the command, and half of full turns any rotor."""
# Keeps the quotient finite where speed and curve are 0 [rad/s].
MIN_SPEED = 1e-30


class CommandCurve(NamedTuple):
    """Coefficients of w^2 = w_c (square w_c + linear): square [1], linear [rad/s]."""

    square: float
    linear: float


class RotorDrive(NamedTuple):
    """Maps between commanded and held rotor speeds [rad/s] as model functions; curve is a `CommandCurve`.

    command_of(speed, curve) -> speeds to command. speed_of(command, curve) -> speeds that are held.
    """

    command_of: Callable[..., Any]
    speed_of: Callable[..., Any]


def command_curve(linear: float, speed_max: float) -> CommandCurve:
    """Return the coefficients of a curve; linear: its share a."""
    return CommandCurve(1.0 - linear, linear * speed_max)


def rotor_command(speed: float, curve: CommandCurve) -> float:
    """Commanded speed at which a rotor holds a speed [rad/s].

    Of the two forms of the root it takes the one that does not cancel.
    """
    root = sqrt(curve.linear * curve.linear + 4.0 * curve.square * speed * speed)
    convex = (root - curve.linear) / (2.0 * maximum(curve.square, 1.0))
    concave = 2.0 * speed * speed / maximum(root + curve.linear, MIN_SPEED)
    return select(curve.linear < 0.0, convex, concave)


def rotor_speed(command: float, curve: CommandCurve) -> float:
    """Speed that a rotor holds at a commanded speed [rad/s]."""
    return sqrt(maximum(command * (curve.square * command + curve.linear), 0.0))


def commands_of(speed: Rotors, curve: CommandCurve) -> Rotors:
    """Commanded speeds at which rotors hold speeds [rad/s]."""
    return Rotors(
        rotor_command(speed.r1, curve),
        rotor_command(speed.r2, curve),
        rotor_command(speed.r3, curve),
        rotor_command(speed.r4, curve),
    )


def speeds_of(command: Rotors, curve: CommandCurve) -> Rotors:
    """Speeds that rotors hold at commanded speeds [rad/s]."""
    return Rotors(
        rotor_speed(command.r1, curve),
        rotor_speed(command.r2, curve),
        rotor_speed(command.r3, curve),
        rotor_speed(command.r4, curve),
    )


def same_speeds(speed: Rotors, curve: CommandCurve) -> Rotors:  # noqa: ARG001
    """The same speeds."""
    return speed


PROPORTIONAL = RotorDrive(same_speeds, same_speeds)
CURVED = RotorDrive(commands_of, speeds_of)
