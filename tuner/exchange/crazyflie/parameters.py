"""Our PID as the parameters of the firmware's cascade: position, velocity, attitude, rate; and back.

The attitude's PID is an attitude loop (P) around a rate loop (PI), see `tuner.exchange.autopilot.pid_cascade`; the position's
a position loop (P) around a velocity loop (PI) whose output is an angle, a/g in degrees, or counts of thrust. Every other
gain of the firmware's loops is written as 0, for its defaults are not 0. Pitch is positive nose up in the firmware, and yaw's
output is negated: angle, rate and torque change their signs together, so no gain does.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import degrees, pi, radians, sqrt

from plant.airframes.actuation import Actuation, actuation
from plant.cascade import LEAST_LIFT
from tuner.exchange.autopilot.parameter_table import parameters as held_against_table
from tuner.exchange.autopilot.parameter_text import single
from tuner.exchange.autopilot.pid import axis_gains, with_gains, with_measured_rates
from tuner.exchange.autopilot.pid_cascade import RateLoop, parallel, rate_loop
from tuner.exchange.crazyflie.scales import check_mixing, force_per_count, torque_per_count
from tuner.exchange.crazyflie.table import ATTITUDE, ENTRIES, HORIZONTAL, INTEGERS
from tuner.exchange.exporter import Parameter
from tuner.gains import Controller

TARGET = "the Crazyflie's firmware"
# The gyro passes a second-order Butterworth filter of 80 Hz; at low frequencies it delays as a first-order one of this time [s].
GYRO_FILTER = sqrt(2.0) / (2.0 * pi * 80.0)


@dataclass(frozen=True)
class Units:
    """What one unit of each loop's output does: angular acceleration for a count [rad/s2] by axis; acceleration for a degree of
    tilt [m/s2]; vertical acceleration for 1000 counts [m/s2]; counts at hover.
    """

    turning: Mapping[str, float]
    leaning: float
    lifting: float
    hover: float


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


def values(controller: Controller, full: float) -> dict[str, float]:
    """Return name -> value, unrounded; raises InputError naming gain or airframe where the firmware has no such loop."""
    one = units(controller, full)
    found = dict.fromkeys(ENTRIES, 0.0)
    for axis in ATTITUDE:
        loop = rate_loop(axis_gains(controller, axis), axis)
        per_degree = radians(1.0) / one.turning[axis]
        found[f"pid_attitude.{axis}_kp"] = loop.outer
        found |= {f"pid_rate.{axis}_kp": loop.p * per_degree, f"pid_rate.{axis}_ki": loop.i * per_degree}
    for axis in (*HORIZONTAL, "z"):
        loop = rate_loop(axis_gains(controller, axis), axis)
        unit = one.lifting if axis == "z" else one.leaning
        found[f"posCtlPid.{axis}Kp"] = loop.outer
        found |= {f"velCtlPid.v{axis}Kp": loop.p / unit, f"velCtlPid.v{axis}Ki": loop.i / unit}
    tilt = degrees(controller.options.tilt_limit)
    found |= {"posCtlPid.rLimit": tilt, "posCtlPid.pLimit": tilt}
    return found | {"posCtlPid.thrustBase": one.hover, "posCtlPid.thrustMin": LEAST_LIFT * one.hover}


def parameters(controller: Controller, full: float) -> tuple[Parameter, ...]:
    """Return every parameter as the vehicle holds it: uint16 or float32; raises InputError naming one that is out of range."""
    asked = values(controller, full)
    whole = {name: value for name, value in asked.items() if name in INTEGERS}
    real = {name: value for name, value in asked.items() if name not in INTEGERS}
    return (
        *held_against_table(ENTRIES, real, single, TARGET),
        *held_against_table(ENTRIES, whole, lambda value: float(round(value)), TARGET),
    )


def held(controller: Controller, full: float, written: Mapping[str, float]) -> Controller:
    """Return the controller that the firmware flies with these parameters; rates come from its gyro and its estimator."""
    one = units(controller, full)
    gains = {}
    for axis in ATTITUDE:
        per_degree = one.turning[axis] / radians(1.0)
        p, i = (written[f"pid_rate.{axis}_{part}"] * per_degree for part in ("kp", "ki"))
        gains[axis] = parallel(RateLoop(written[f"pid_attitude.{axis}_kp"], p, i), GYRO_FILTER)
    for axis in (*HORIZONTAL, "z"):
        unit = one.lifting if axis == "z" else one.leaning
        p, i = (written[f"velCtlPid.v{axis}{part}"] * unit for part in ("Kp", "Ki"))
        gains[axis] = parallel(RateLoop(written[f"posCtlPid.{axis}Kp"], p, i), 0.0)
    tilt = radians(written["posCtlPid.rLimit"])
    limited = replace(controller, options=replace(controller.options, tilt_limit=tilt))
    return with_measured_rates(with_gains(limited, gains))
