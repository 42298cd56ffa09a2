"""Betaflight 2025.12: what its command line prints for `diff` or `dump`, as a PID controller of ours.

Betaflight has no heading loop and no position loops of this form: the former is an option, the latter stand at our defaults.
"""

from collections.abc import Mapping
from math import degrees
from pathlib import Path

from plant.airframes import Airframe
from plant.airframes.actuation import actuation
from plant.cascade import ATTITUDE_AXES
from plant.errors import InputError
from tuner.export.betaflight import NAME, profile
from tuner.export.betaflight_map import betaflight_torque, from_betaflight, tilt_limit
from tuner.export.betaflight_ranges import SWITCHES, TABLE
from tuner.export.betaflight_text import read_cli, whole
from tuner.export.exporter import Option
from tuner.export.parameter_table import defaults
from tuner.export.settings import number
from tuner.importing.assembly import (
    ATTITUDE_FILTER,
    CURVE,
    DERIVATIVE,
    POSITION_FILTER,
    absent_note,
    assumed_note,
    control_period,
    controller,
    curve,
    filters,
    inertia_note,
    lightened,
    tilt_note,
    unused_note,
)
from tuner.importing.importer import Imported, Importer

# Output per setting D and deg/s2, src/main/flight/pid.h.
D_SCALE = 0.000529
# Names of the settings before they were renamed: a file of another version.
RENAMED = {"angle_level_strength": "angle_p_gain", "level_limit": "angle_limit", "d_min_roll": "d_roll"}

HEADING = Option("heading_gain", "angle loop around the yaw rate, which Betaflight has not, 1/s", default="2")
PROFILE = Option("profile", "PID profile that is read, 0 to 3", default="0")


def read(file: Path, airframe: Airframe, settings: Mapping[str, str]) -> Imported:
    """Return the controller of a file; raises InputError naming file and setting."""
    texts = read_cli(file, profile(settings))
    check_version(texts, file)
    given = {name: whole(text, name, file) for name, text in texts.items() if name in TABLE}
    values = defaults(TABLE) | given
    vehicle = airframe.vehicle
    rotors = actuation(vehicle, curve(settings))
    heading = number(settings, HEADING.name, 0.01, 50.0, "1/s")
    gains = from_betaflight(values, vehicle, rotors, filters(settings), heading)
    shares = {
        f"d_{axis}": values[f"d_{axis}"] * D_SCALE * degrees(torque / inertia)
        for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, betaflight_torque(rotors), strict=True)
    }
    if settings[DERIVATIVE.name] == "inertia":
        gains = {axis: lightened(loop, shares[f"d_{axis}"]) for axis, loop in gains.items()}
    tilt = tilt_limit(values)
    others = (
        "f_roll",
        "f_pitch",
        "f_yaw",
        "angle_feedforward",
        "anti_gravity_gain",
        "tpa_rate",
        "yaw_lowpass_hz",
        "thrust_linear",
    )
    notes = (
        f"Read as {NAME}, with the rotors of the airframe {airframe.name} and their slope at hover.",
        f"The heading loop is {heading:g} 1/s, as set; the position loops stand at our defaults: Betaflight has neither.",
        *absent_note(texts, defaults(TABLE), NAME),
        *inertia_note(shares, settings[DERIVATIVE.name] == "inertia"),
        *unused_note(values, others, "Terms that our law has not are left out"),
        *_switches(texts),
        *tilt_note(tilt, "angle_limit"),
    )
    return Imported(controller(file, airframe, gains, tilt, settings), (*notes, assumed_note(settings)))


def check_version(texts: Mapping[str, str], file: Path) -> None:
    """Refuse settings of other versions and of ADRC; raises InputError naming the setting."""
    for old, current in RENAMED.items():
        if old in texts:
            message = (
                f"is a setting of Betaflight before 2025.12, now {current}; give the file of a vehicle with {NAME}"
            )
            raise InputError(message, file=file, key=old)
    if texts.get("pid_type", "CLASSIC") != "CLASSIC":
        message = (
            f"given {texts['pid_type']}; only pid_type = CLASSIC can be read as a PID: give the file of such a profile"
        )
        raise InputError(message, file=file, key="pid_type")
    if texts.get("use_integrated_yaw", "OFF") != "OFF":
        message = "given ON; integrated yaw is another law than PID: set it OFF on the vehicle and give the file again"
        raise InputError(message, file=file, key="use_integrated_yaw")


def _switches(texts: Mapping[str, str]) -> tuple[str, ...]:
    there = [
        f"{name} = {texts.get(name, usual)}" for name, (off, usual) in SWITCHES.items() if texts.get(name, usual) != off
    ]
    return (f"Switches that change the loops, or the gains, beside what is read: {', '.join(there)}.",) if there else ()


IMPORTER = Importer(
    name="betaflight",
    title=f"{NAME}, what the command line prints for diff or dump",
    options=(PROFILE, HEADING, control_period("0.001"), CURVE, ATTITUDE_FILTER, POSITION_FILTER, DERIVATIVE),
    read=read,
)
