"""The firmware's PID parameters: names, units, defaults of platform cf2, and where they come from.

bitcraze/crazyflie-firmware, src/modules/src/controller/attitude_pid_controller.c, position_controller_pid.c and
src/platform/interface/platform_defaults_cf2.h, as of 2025 and 2026. Angles and rates are in degrees. The firmware documents no
ranges; the upper ends here are where arithmetic ends: a rate loop whose output, an int16, is full at 1 deg/s, and an outer loop
that steps over its target within one period (500 Hz for attitude, 100 Hz for position).
"""

from tuner.exchange.autopilot.parameter_table import Entry
from tuner.exchange.autopilot.parameter_text import MOST

INT16, UINT16 = 32767.0, 65535.0
ATTITUDE_RATE, POSITION_RATE = 500.0, 100.0
ATTITUDE, HORIZONTAL = ("roll", "pitch", "yaw"), ("x", "y")


def _rate(axis: str, kp: float, ki: float, kd: float) -> list[Entry]:
    group = f"pid_rate.{axis}_"
    return [
        Entry(f"{group}kp", "counts/(deg/s)", 0.0, INT16, kp, f"{axis}.kd"),
        Entry(f"{group}ki", "counts/deg", 0.0, INT16 * ATTITUDE_RATE, ki, f"{axis}.ki"),
        Entry(f"{group}kd", "counts/(deg/s2)", 0.0, INT16, kd, f"{axis}.kd"),
        Entry(f"{group}kff", "counts/(deg/s)", 0.0, INT16, 0.0, f"{axis}.kp"),
    ]


def _outer(
    group: str, names: tuple[str, str, str, str], usual: tuple[float, float, float], rate: float, axis: str
) -> list[Entry]:
    units = ("1/s", "1/s2", "1", "1/s")
    return [
        Entry(f"{group}{name}", unit, 0.0, rate, value, f"{axis}.kp")
        for name, unit, value in zip(names, units, (*usual, 0.0), strict=True)
    ]


def _velocity(axis: str, unit: str, kp: float, ki: float) -> list[Entry]:
    group = f"velCtlPid.v{axis}"
    return [
        Entry(f"{group}Kp", f"{unit}/(m/s)", 0.0, MOST, kp, f"{axis}.kd"),
        Entry(f"{group}Ki", f"{unit}/m", 0.0, MOST, ki, f"{axis}.ki"),
        Entry(f"{group}Kd", f"{unit}/(m/s2)", 0.0, MOST, 0.0, f"{axis}.kd"),
        Entry(f"{group}KFF", f"{unit}/(m/s)", 0.0, MOST, 0.0, f"{axis}.kd"),
    ]


def _entries() -> list[Entry]:
    angle, place = ("kp", "ki", "kd", "kff"), ("Kp", "Ki", "Kd", "Kff")
    return [
        *_rate("roll", 250.0, 500.0, 2.5),
        *_rate("pitch", 250.0, 500.0, 2.5),
        *_rate("yaw", 120.0, 16.7, 0.0),
        *_outer("pid_attitude.roll_", angle, (6.0, 3.0, 0.0), ATTITUDE_RATE, "roll"),
        *_outer("pid_attitude.pitch_", angle, (6.0, 3.0, 0.0), ATTITUDE_RATE, "pitch"),
        *_outer("pid_attitude.yaw_", angle, (6.0, 1.0, 0.35), ATTITUDE_RATE, "yaw"),
        *_velocity("x", "deg", 25.0, 1.0),
        *_velocity("y", "deg", 25.0, 1.0),
        *_velocity("z", "kilocounts", 25.0, 15.0),
        *_outer("posCtlPid.x", place, (2.0, 0.0, 0.0), POSITION_RATE, "x"),
        *_outer("posCtlPid.y", place, (2.0, 0.0, 0.0), POSITION_RATE, "y"),
        *_outer("posCtlPid.z", place, (2.0, 0.5, 0.0), POSITION_RATE, "z"),
        Entry("posCtlPid.rLimit", "deg", 0.0, 90.0, 20.0, "the tilt limit"),
        Entry("posCtlPid.pLimit", "deg", 0.0, 90.0, 20.0, "the tilt limit"),
        Entry("posCtlPid.thrustBase", "counts", 0.0, UINT16, 36000.0, "the airframe's mass"),
        Entry("posCtlPid.thrustMin", "counts", 0.0, UINT16, 20000.0, "the airframe's mass"),
    ]


ENTRIES = {entry.name: entry for entry in _entries()}
# Held as uint16; all others are float32.
INTEGERS = frozenset({"posCtlPid.thrustBase", "posCtlPid.thrustMin"})
