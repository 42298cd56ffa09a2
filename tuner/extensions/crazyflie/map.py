"""Our PID as the parameters of the firmware's cascade: position, velocity, attitude, rate; and back.

The attitude's PID is an attitude loop (P) around a rate loop (PI), see `tuner.extensions.autopilots.pid`; the position's
a position loop (P) around a velocity loop (PI) whose output is an angle, a/g in degrees, or counts of thrust. Every other
gain of the firmware's loops is written as 0, because its defaults are not 0. Pitch is positive nose up in the firmware, and yaw's
output is negated: angle, rate and torque change their signs together, so no gain does.

Parameters of platform cf2: bitcraze/crazyflie-firmware, src/modules/src/controller/attitude_pid_controller.c,
position_controller_pid.c and src/platform/interface/platform_defaults_cf2.h, as of 2025 and 2026, in degrees. The firmware
documents no ranges; the upper ends here are a rate loop whose output, an int16, is full at 1 deg/s, and an outer loop
that overshoots its target within one period (500 Hz for attitude, 100 Hz for position).

In legacy mode the motors get thrust -+ roll/2 +- pitch/2 +- yaw, in counts of which 65535 are the full thrust of a motor
(power_distribution_quadrotor.c); battery compensation makes thrust proportional to counts. For a square X this is
4 l/2 T/65535 N m for a count of roll, 4 k_m T/65535 for a count of yaw. Signs are those of body FRD.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import degrees, pi, radians, sqrt

import numpy as np

from plant.errors import InputError
from plant.laws.pid import Gains
from plant.quadrotor.airframes.actuation import Actuation, actuation
from plant.quadrotor.cascade import MIN_LIFT
from tuner.exchange.target import HeldParameter
from tuner.extensions.autopilots.cascade import CascadeNames
from tuner.extensions.autopilots.parameters import (
    MAX_VALUE,
    NOTHING,
    ParameterInfo,
    Values,
    defaults,
    parameter_table,
    single,
)
from tuner.extensions.autopilots.parameters import parameters as held_against_table
from tuner.extensions.autopilots.pid import RateLoop, axis_gains, parallel, rate_loop, with_gains, with_measured_rates
from tuner.extensions.autopilots.scales import Motors, TorqueScale, torque_scale
from tuner.gains import Controller

INT16, UINT16 = 32767.0, 65535.0
ATTITUDE_RATE, POSITION_RATE = 500.0, 100.0
ATTITUDE, HORIZONTAL = ("roll", "pitch", "yaw"), ("x", "y")


def _rate(axis: str, kp: float, ki: float, kd: float) -> list[ParameterInfo]:
    group = f"pid_rate.{axis}_"
    return [
        ParameterInfo(f"{group}kp", "counts/(deg/s)", 0.0, INT16, kp, f"{axis}.kd"),
        ParameterInfo(f"{group}ki", "counts/deg", 0.0, INT16 * ATTITUDE_RATE, ki, f"{axis}.ki"),
        ParameterInfo(f"{group}kd", "counts/(deg/s2)", 0.0, INT16, kd, f"{axis}.kd"),
        ParameterInfo(f"{group}kff", "counts/(deg/s)", 0.0, INT16, 0.0, f"{axis}.kp"),
    ]


def _outer(
    group: str, names: tuple[str, str, str, str], usual: tuple[float, float, float], rate: float, axis: str
) -> list[ParameterInfo]:
    units = ("1/s", "1/s2", "1", "1/s")
    return [
        ParameterInfo(f"{group}{name}", unit, 0.0, rate, value, f"{axis}.kp")
        for name, unit, value in zip(names, units, (*usual, 0.0), strict=True)
    ]


def _velocity(axis: str, unit: str, kp: float, ki: float) -> list[ParameterInfo]:
    group = f"velCtlPid.v{axis}"
    return [
        ParameterInfo(f"{group}Kp", f"{unit}/(m/s)", 0.0, MAX_VALUE, kp, f"{axis}.kd"),
        ParameterInfo(f"{group}Ki", f"{unit}/m", 0.0, MAX_VALUE, ki, f"{axis}.ki"),
        ParameterInfo(f"{group}Kd", f"{unit}/(m/s2)", 0.0, MAX_VALUE, 0.0, f"{axis}.kd"),
        ParameterInfo(f"{group}KFF", f"{unit}/(m/s)", 0.0, MAX_VALUE, 0.0, f"{axis}.kd"),
    ]


ANGLE, PLACE = ("kp", "ki", "kd", "kff"), ("Kp", "Ki", "Kd", "Kff")
ENTRIES = parameter_table(
    *_rate("roll", 250.0, 500.0, 2.5),
    *_rate("pitch", 250.0, 500.0, 2.5),
    *_rate("yaw", 120.0, 16.7, 0.0),
    *_outer("pid_attitude.roll_", ANGLE, (6.0, 3.0, 0.0), ATTITUDE_RATE, "roll"),
    *_outer("pid_attitude.pitch_", ANGLE, (6.0, 3.0, 0.0), ATTITUDE_RATE, "pitch"),
    *_outer("pid_attitude.yaw_", ANGLE, (6.0, 1.0, 0.35), ATTITUDE_RATE, "yaw"),
    *_velocity("x", "deg", 25.0, 1.0),
    *_velocity("y", "deg", 25.0, 1.0),
    *_velocity("z", "kilocounts", 25.0, 15.0),
    *_outer("posCtlPid.x", PLACE, (2.0, 0.0, 0.0), POSITION_RATE, "x"),
    *_outer("posCtlPid.y", PLACE, (2.0, 0.0, 0.0), POSITION_RATE, "y"),
    *_outer("posCtlPid.z", PLACE, (2.0, 0.5, 0.0), POSITION_RATE, "z"),
    ParameterInfo("posCtlPid.rLimit", "deg", 0.0, 90.0, 20.0, "the tilt limit"),
    ParameterInfo("posCtlPid.pLimit", "deg", 0.0, 90.0, 20.0, "the tilt limit"),
    ParameterInfo("posCtlPid.thrustBase", "counts", 0.0, UINT16, 36000.0, "the airframe's mass"),
    ParameterInfo("posCtlPid.thrustMin", "counts", 0.0, UINT16, 20000.0, "the airframe's mass"),
)
NAMES = {
    **{
        axis: CascadeNames(f"pid_attitude.{axis}_kp", *(f"pid_rate.{axis}_k{term}" for term in "pid"))
        for axis in ATTITUDE
    },
    **{axis: CascadeNames(f"posCtlPid.{axis}Kp", *(f"velCtlPid.v{axis}K{term}" for term in "pid")) for axis in "xyz"},
}
TILT = ("posCtlPid.rLimit", "posCtlPid.pLimit")
# Low-pass on the D terms of the rate loops, off by default: one switch, a cut-off for each axis. Read when the firmware starts.
FILTER_SWITCH = "pid_rate.rateFiltEn"
FILTER_CUTOFFS = {axis: f"pid_rate.om{letter}FiltCut" for axis, letter in zip(ATTITUDE, "xyz", strict=True)}
FILTERS = {
    FILTER_SWITCH: ParameterInfo(FILTER_SWITCH, "1", 0.0, 1.0, 0.0, "attitude.d_cutoff"),
    **{
        name: ParameterInfo(name, "Hz", 0.0, 0.5 * ATTITUDE_RATE, 30.0, f"{axis}.d_cutoff")
        for axis, name in FILTER_CUTOFFS.items()
    },
}
TABLE = {**ENTRIES, **FILTERS}
"""Every parameter that acts in the loops."""
# Held as whole numbers; all others are float32.
INTEGERS = frozenset({"posCtlPid.thrustBase", "posCtlPid.thrustMin", FILTER_SWITCH})


# The firmware's numbers of our rotors 1 to 4.
MOTORS: Motors = (4, 1, 3, 2)
# Motors in our order (front left, front right, rear left, rear right) by roll, pitch, yaw.
FACTORS = np.array([[0.5, 0.5, -1.0], [-0.5, 0.5, 1.0], [0.5, -0.5, 1.0], [-0.5, -0.5, -1.0]])
SPIN = (1.0, -1.0, -1.0, 1.0)


def check_mixing(actuation: Actuation) -> None:
    """Refuse an airframe that the firmware's fixed X mixing does not fit; raises InputError naming what of it."""
    if tuple(rotor.spin for rotor in actuation.rotors) != SPIN:
        message = (
            "given '-++-'; the Crazyflie's firmware mixes for '+--+' (the front left propeller, motor 4, turns clockwise seen "
            "from above): with the other sense its yaw loop would be unstable"
        )
        raise InputError(message, key="airframe.spin")
    torque_per_count(actuation, actuation.thrust_max)


def torque_per_count(actuation: Actuation, full: float) -> TorqueScale:
    """Return the torque per count about each axis [N m]; full: thrust of one motor at 65535 counts [N].

    Raises InputError where the mixing couples axes on this airframe.
    """
    return torque_scale(actuation, FACTORS, full / UINT16, "the Crazyflie's X mixing")


def force_per_count(full: float) -> float:
    """Return the force of all motors for one count of thrust [N]."""
    return 4.0 * full / UINT16


NAME = "the Crazyflie's firmware"
# The gyro passes a second-order Butterworth filter of 80 Hz; at low frequencies it delays as a first-order one of this time [s].
GYRO_FILTER = sqrt(2.0) / (2.0 * pi * 80.0)


@dataclass(frozen=True)
class Units:
    """Effect of one unit of each loop's output: angular acceleration for a count [rad/s2] by axis; acceleration for a degree of
    tilt [m/s2]; vertical acceleration for 1000 counts [m/s2]; counts at hover.
    """

    turning: Mapping[str, float]
    leaning: float
    lifting: float
    hover: float

    def written(self, axis: str, p: float, i: float) -> tuple[float, float]:
        """Return P and I of an inner loop in the firmware's units."""
        if axis in self.turning:
            per_degree = radians(1.0) / self.turning[axis]
            return p * per_degree, i * per_degree
        unit = self.lifting if axis == "z" else self.leaning
        return p / unit, i / unit

    def ours(self, axis: str, p: float, i: float) -> tuple[float, float]:
        """Return P and I of an inner loop in our units."""
        if axis in self.turning:
            unit = self.turning[axis] / radians(1.0)
        else:
            unit = self.lifting if axis == "z" else self.leaning
        return p * unit, i * unit


def units(controller: Controller, full: float) -> Units:
    """Work out the units for an airframe; full: thrust of one motor at 65535 counts [N]."""
    vehicle = controller.airframe.vehicle
    rotors: Actuation = actuation(vehicle)
    check_mixing(rotors)
    torque = torque_per_count(rotors, full)
    return Units(
        {axis: getattr(torque, axis) / inertia for axis, inertia in zip(ATTITUDE, vehicle.inertia, strict=True)},
        radians(1.0) * vehicle.gravity,
        1000.0 * force_per_count(full) / vehicle.mass,
        vehicle.mass * vehicle.gravity / force_per_count(full),
    )


def values(
    controller: Controller, full: float, axes: Iterable[str] = NAMES, before: Values = NOTHING
) -> dict[str, float]:
    """Return name -> value, unrounded, our PID on some axes.

    before: what is on the vehicle; of the two forms that one feedback has, the one nearer to that is taken. Raises InputError
    naming gain or airframe where the firmware has no such loop.
    """
    one, present = units(controller, full), {**defaults(TABLE), **before}
    by_name = dict.fromkeys(ENTRIES, 0.0)
    for axis in axes:
        names = NAMES[axis]
        near = RateLoop(present[names.outer], *one.ours(axis, present[names.p], present[names.i])) if before else None
        loop = rate_loop(axis_gains(controller, axis), axis, near)
        p, i = one.written(axis, loop.p, loop.i)
        by_name |= {names.outer: loop.outer, names.p: p, names.i: i}
    by_name |= dict.fromkeys(TILT, degrees(controller.options.tilt_limit))
    return by_name | {"posCtlPid.thrustBase": one.hover, "posCtlPid.thrustMin": MIN_LIFT * one.hover}


def parameters(controller: Controller, full: float) -> tuple[HeldParameter, ...]:
    """Return every parameter as the vehicle holds it: uint16 or float32; raises InputError naming one that is out of range."""
    return rounded(values(controller, full))


def rounded(unrounded: Values, before: Values = NOTHING) -> tuple[HeldParameter, ...]:
    """Return parameters as the vehicle holds them; before: what is on it; raises InputError naming one that is out of range."""
    integers = {name: value for name, value in unrounded.items() if name in INTEGERS}
    real = {name: value for name, value in unrounded.items() if name not in INTEGERS}
    return (
        *held_against_table(TABLE, real, single, NAME, before),
        *held_against_table(TABLE, integers, lambda value: float(round(value)), NAME, before),
    )


def held(controller: Controller, full: float, written: Values) -> Controller:
    """Return the controller that the firmware flies with these parameters; rates come from its gyro and its estimator."""
    filters = {axis: GYRO_FILTER if axis in ATTITUDE else 0.0 for axis in NAMES}
    limited = replace(controller, options=replace(controller.options, tilt_limit=radians(written[TILT[0]])))
    return with_measured_rates(with_gains(limited, pid_gains(units(controller, full), written, filters)))


def pid_gains(one: Units, written: Values, filters: Mapping[str, float]) -> dict[str, Gains]:
    """Return our PID's gains on some axes; filters: time constants t_f [s]."""
    gains = {}
    for axis, t_f in filters.items():
        names = NAMES[axis]
        p, i = one.ours(axis, written[names.p], written[names.i])
        gains[axis] = parallel(RateLoop(written[names.outer], p, i), t_f)
    return gains
