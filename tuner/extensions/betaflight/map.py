"""Our attitude PID as Betaflight's rate PI and level strength, and back.

Rates are in deg/s and outputs in thousandths of the motor range: P and I of the settings are multiplied by 0.032029 and 0.244381,
the latter by 2.5 more for yaw (src/main/flight/pid.h, pid_init.c). Thrust does not follow the command, so a unit of output is
worth the slope of the thrust curve at hover. Pitch is positive nose down and yaw clockwise; diagonal gains are the same.

Settings of Betaflight 2025.12 that an export writes: units, ranges, defaults.

betaflight/betaflight, release 2025.12: src/main/cli/settings.c, src/main/flight/pid.h and pid.c (pgResetFn_pidProfiles). The
firmware enforces these ranges; a test checks each of them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import degrees, pi, radians
from typing import NamedTuple

from plant.laws.pid import Gains
from plant.quadrotor.airframes.actuation import Actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.autopilots.parameters import ParameterInfo, parameter_table
from tuner.extensions.autopilots.pid import RateLoop, axis_gains, parallel, rate_loop
from tuner.extensions.autopilots.scales import TorqueScale, betaflight_factors, command_slope, torque_scale
from tuner.gains import Controller

OFF = "nothing: it is switched off"


class RateNames(NamedTuple):
    """Settings of one rate loop: P, I, lower and upper D, feed-forward."""

    p: str
    i: str
    d: str
    d_max: str
    f: str


NAMES = {axis: RateNames(*(f"{term}_{axis}" for term in RateNames._fields)) for axis in ATTITUDE_AXES}


def _axis(axis: str, p: float, i: float, d: float, d_max: float, f: float) -> list[ParameterInfo]:
    """Return one rate loop with its defaults."""
    names = NAMES[axis]
    return [
        ParameterInfo(names.p, "1", 0.0, 250.0, p, f"{axis}.kd"),
        ParameterInfo(names.i, "1", 0.0, 250.0, i, f"{axis}.ki"),
        ParameterInfo(names.d, "1", 0.0, 250.0, d, OFF),
        ParameterInfo(names.d_max, "1", 0.0, 250.0, d_max, OFF),
        ParameterInfo(names.f, "1", 0.0, 1000.0, f, OFF),
    ]


TABLE = parameter_table(
    *_axis("roll", 45.0, 80.0, 30.0, 40.0, 120.0),
    *_axis("pitch", 47.0, 84.0, 34.0, 46.0, 125.0),
    *_axis("yaw", 45.0, 80.0, 0.0, 0.0, 120.0),
    ParameterInfo("angle_p_gain", "0.1/s", 0.0, 200.0, 50.0, "roll.kp, roll.ki or roll.kd"),
    ParameterInfo("angle_feedforward", "1", 0.0, 200.0, 50.0, OFF),
    ParameterInfo("angle_limit", "deg", 10.0, 80.0, 60.0, "controller.tilt_limit"),
    ParameterInfo("anti_gravity_gain", "1", 0.0, 250.0, 80.0, OFF),
    ParameterInfo("tpa_rate", "%", 0.0, 100.0, 65.0, OFF),
    ParameterInfo("yaw_lowpass_hz", "Hz", 0.0, 500.0, 100.0, OFF),
    ParameterInfo("thrust_linear", "%", 0.0, 150.0, 0.0, OFF),
)
# Switches: setting -> what the export sets, the default.
SWITCHES = {"simplified_pids_mode": ("OFF", "RPY"), "iterm_relax": ("OFF", "RP")}
# Terms that our law has not: an export to a known vehicle leaves them as they are there.
EXTRA = (*(entry.name for entry in TABLE.values() if entry.source == OFF), "iterm_relax")
# What else acts in the loops, with its default in 2025.12; an import names what stands otherwise, an export leaves it alone.
OTHERS = {
    "yaw_motors_reversed": "OFF",
    "iterm_windup": "80",
    "pidsum_limit": "500",
    "pidsum_limit_yaw": "400",
    "iterm_rotation": "OFF",
    "abs_control_gain": "0",
    "motor_output_limit": "100",
    "throttle_boost": "5",
    "vbat_sag_compensation": "0",
    "dyn_idle_min_rpm": "0",
    "level_race_mode": "OFF",
    "crash_recovery": "OFF",
}
# The gyro's and the D terms' filters, and the rate of the loops.
FILTERS = (
    r"(gyro|dterm)_(lpf|notch)\w*|dyn_notch_\w+|rpm_filter_\w+|simplified_(gyro|dterm)_filter\w*|pid_process_denom"
)


@dataclass(frozen=True)
class Release:
    """A series of releases. renamed: name of a setting there -> name in 2025.12; usual: defaults there that are others, by the
    names of 2025.12. Their gains have one scale.
    """

    name: str
    renamed: Mapping[str, str] = field(default_factory=dict)
    usual: Mapping[str, str] = field(default_factory=dict)

    @property
    def current(self) -> bool:
        """True where an export for 2025.12 has its names."""
        return not self.renamed


# Before 2025.12 d was the upper and d_min the lower D gain; then d_max is the upper and d the lower one.
_D = {f"d_min_{axis}": f"d_{axis}" for axis in ("roll", "pitch", "yaw")} | {
    f"d_{axis}": f"d_max_{axis}" for axis in ("roll", "pitch", "yaw")
}
_LEVEL = {"angle_level_strength": "angle_p_gain", "level_limit": "angle_limit"}
_OLD = {"iterm_windup": "85", "iterm_limit": "400"}
_FEWER = {"angle_limit": "55", "angle_feedforward": "0"}
# Tags 4.3.1, 4.4.3, 4.5.5, 2025.12.5, 2026.6.1 of the firmware; 4.6 was the name of 2025.12 while it was made.
RELEASES = {
    release.name: release
    for release in (
        Release("4.3", _D | _LEVEL, _OLD | _FEWER | {"anti_gravity_gain": "3500"}),
        Release("4.4", _D | _LEVEL, _OLD | _FEWER),
        Release("4.5", _D, _OLD),
        Release("4.6"),
        Release("2025.12"),
        Release("2026.6"),
        Release("2026.12"),
    )
}
USUAL = RELEASES["2025.12"]
"""Release of a file that names none."""


NAME = "Betaflight"
ANGLE_GAIN, ANGLE_LIMIT = "angle_p_gain", "angle_limit"
# Torque output per setting and deg/s (P), per setting and deg (I); I of yaw counts more.
P_SCALE, I_SCALE, YAW_I = 0.032029, 0.244381, 2.5
# Outputs of the loops for the whole motor range, and level strength of 1/s.
MIXER, LEVEL = 1000.0, 10.0
DEGREE = pi / 180.0


def betaflight_torque(actuation: Actuation) -> TorqueScale:
    """Return the torque per unit of the loops' outputs [N m]: at hover."""
    slope = command_slope(actuation, 0.0) / MIXER
    return torque_scale(actuation, betaflight_factors(actuation), slope, NAME)


def _scales(axis: str, inertia: float, torque: float) -> tuple[float, float]:
    """Return settings P and I per unit of our rate loop: 1/s and 1/s2."""
    scale = inertia * DEGREE / torque
    return scale / P_SCALE, scale / (I_SCALE * (YAW_I if axis == "yaw" else 1.0))


def loops(controller: Controller, actuation: Actuation, before: Mapping[str, float]) -> dict[str, RateLoop]:
    """Return the cascaded form of the attitude axes; before: settings of the vehicle, or none.

    One feedback has two such forms, with angle gain and I over P in either place. Taken is the one with the larger angle gain,
    or for a known vehicle the one nearer to its present: in roll and pitch by angle_p_gain, in yaw, which has none, by i_yaw.
    """
    forms: dict[str, RateLoop] = {}
    for axis, inertia, torque in zip(
        ATTITUDE_AXES, controller.airframe.vehicle.inertia, betaflight_torque(actuation), strict=True
    ):
        larger = rate_loop(axis_gains(controller, axis), axis)
        smaller = RateLoop(larger.i / larger.p, larger.p, larger.p * larger.outer)
        forms[axis] = larger
        if before and larger.i > 0.0:
            present = before["i_yaw" if axis == "yaw" else ANGLE_GAIN]
            setting = _scales(axis, inertia, torque)[1]
            away = [
                abs((setting * form.i if axis == "yaw" else LEVEL * form.outer) - present) for form in (larger, smaller)
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
        names = NAMES[axis]
        values |= {names.p: p * cascade[axis].p, names.i: i * cascade[axis].i, **dict.fromkeys(names[2:], 0.0)}
    return values | {
        ANGLE_GAIN: LEVEL * cascade["roll"].outer,
        "angle_feedforward": 0.0,
        ANGLE_LIMIT: degrees(controller.options.tilt_limit),
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
        outer = yaw_outer if axis == "yaw" else values[ANGLE_GAIN] / LEVEL
        gains[axis] = parallel(RateLoop(outer, values[NAMES[axis].p] / p, values[NAMES[axis].i] / i), filters[axis])
    return gains


def tilt_limit(values: Mapping[str, float]) -> float:
    """Return the largest tilt [rad]."""
    return radians(values[ANGLE_LIMIT])


def reversed_yaw(rotors: Actuation) -> str:
    """Return the setting yaw_motors_reversed for the sense of the rotors: OFF where the front left one turns clockwise."""
    return "OFF" if rotors.rotors[0].spin > 0.0 else "ON"
