"""Our attitude PID as Betaflight's rate PI and level strength, and back.

Rates are in deg/s and outputs in thousandths of the motor range: P and I of the settings are multiplied by 0.032029 and 0.244381,
the latter by 2.5 more for yaw (src/main/flight/pid.h, pid_init.c). Thrust does not follow the command, so a unit of output is
worth the slope of the thrust curve at hover. The firmware counts pitch nose down and yaw clockwise; diagonal gains do not notice.
"""

from collections.abc import Mapping
from math import degrees, pi, radians

from plant.airframes.actuation import Actuation
from plant.cascade import ATTITUDE_AXES
from plant.laws.pid import Gains
from plant.vehicle import Vehicle
from tuner.exchange.autopilot.pid import axis_gains
from tuner.exchange.autopilot.pid_cascade import RateLoop, parallel, rate_loop
from tuner.exchange.autopilot.scales import TorqueScale, betaflight_factors, command_slope, torque_scale
from tuner.gains import Controller

TARGET = "Betaflight"
# Torque output per setting and deg/s (P), per setting and deg (I); I of yaw counts more.
P_SCALE, I_SCALE, YAW_I = 0.032029, 0.244381, 2.5
# Outputs of the loops for the whole motor range, and level strength of 1/s.
MIXER, LEVEL = 1000.0, 10.0
DEGREE = pi / 180.0


def betaflight_torque(actuation: Actuation) -> TorqueScale:
    """Return the torque for one unit of the loops' outputs [N m], at hover."""
    slope = command_slope(actuation, 0.0) / MIXER
    return torque_scale(actuation, betaflight_factors(actuation), slope, TARGET)


def _scales(axis: str, inertia: float, torque: float) -> tuple[float, float]:
    """Return setting P for 1/s and setting I for 1/s2 of our rate loop."""
    scale = inertia * DEGREE / torque
    return scale / P_SCALE, scale / (I_SCALE * (YAW_I if axis == "yaw" else 1.0))


def loops(controller: Controller, actuation: Actuation, before: Mapping[str, float]) -> dict[str, RateLoop]:
    """Return the cascaded form of the attitude axes; before: settings of the vehicle, or none.

    One feedback has two such forms, with angle gain and I over P in either place. Taken is the one with the larger angle gain,
    or for a known vehicle the one nearer to its own: in roll and pitch by angle_p_gain, in yaw, which has none, by i_yaw.
    """
    forms: dict[str, RateLoop] = {}
    for axis, inertia, torque in zip(
        ATTITUDE_AXES, controller.airframe.vehicle.inertia, betaflight_torque(actuation), strict=True
    ):
        larger = rate_loop(axis_gains(controller, axis), axis)
        smaller = RateLoop(larger.i / larger.p, larger.p, larger.p * larger.outer)
        forms[axis] = larger
        if before and larger.i > 0.0:
            own = before["i_yaw"] if axis == "yaw" else before["angle_p_gain"]
            setting = _scales(axis, inertia, torque)[1]
            away = [
                abs((setting * form.i if axis == "yaw" else LEVEL * form.outer) - own) for form in (larger, smaller)
            ]
            forms[axis] = smaller if away[1] < away[0] else larger
    return forms


def to_betaflight(
    controller: Controller, actuation: Actuation, before: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Return the settings, unrounded; the level strength is that of roll. before: see `loops`."""
    cascade = loops(controller, actuation, before or {})
    values: dict[str, float] = {}
    torques = betaflight_torque(actuation)
    for axis, inertia, torque in zip(ATTITUDE_AXES, controller.airframe.vehicle.inertia, torques, strict=True):
        p, i = _scales(axis, inertia, torque)
        values |= {f"p_{axis}": p * cascade[axis].p, f"i_{axis}": i * cascade[axis].i}
        values |= {f"d_{axis}": 0.0, f"d_max_{axis}": 0.0, f"f_{axis}": 0.0}
    return values | {
        "angle_p_gain": LEVEL * cascade["roll"].outer,
        "angle_feedforward": 0.0,
        "angle_limit": degrees(controller.options.tilt_limit),
        "anti_gravity_gain": 0.0,
        "tpa_rate": 0.0,
        "yaw_lowpass_hz": 0.0,
        "thrust_linear": 0.0,
    }


def from_betaflight(
    values: Mapping[str, float], vehicle: Vehicle, actuation: Actuation, filters: Mapping[str, float], yaw_outer: float
) -> dict[str, Gains]:
    """Return our attitude gains for settings of Betaflight; filters: t_f by axis [s]; yaw_outer: heading loop [1/s], which the
    firmware has not.
    """
    gains: dict[str, Gains] = {}
    for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, betaflight_torque(actuation), strict=True):
        p, i = _scales(axis, inertia, torque)
        outer = yaw_outer if axis == "yaw" else values["angle_p_gain"] / LEVEL
        gains[axis] = parallel(RateLoop(outer, values[f"p_{axis}"] / p, values[f"i_{axis}"] / i), filters[axis])
    return gains


def tilt_limit(values: Mapping[str, float]) -> float:
    """Return the largest tilt [rad]."""
    return radians(values["angle_limit"])
