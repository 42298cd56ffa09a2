"""ArduPilot Copter 4.6 and 4.7: a parameter file as a PID controller of ours, on an airframe that the file does not describe."""

from collections.abc import Mapping
from math import radians
from pathlib import Path

from plant.airframes import Airframe
from plant.airframes.actuation import actuation
from plant.cascade import ATTITUDE_AXES
from tuner.export.ardupilot_map import SHORT, ardupilot_scales, from_ardupilot, held_vertical, tilt_limit
from tuner.export.ardupilot_ranges import DIALECTS, FIRMWARES, Dialect, check_names
from tuner.export.ardupilot_text import read_param
from tuner.export.exporter import Option
from tuner.export.parameter_table import defaults
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

# Parameter of the largest lean angle where PSC_ANGLE_MAX is 0 -> its unit in degrees; both default to 30 deg.
LEAN = {"4.6": ("ANGLE_MAX", 0.01, 3000.0), "4.7": ("ATC_ANGLE_MAX", 1.0, 30.0)}
FIRMWARE = Option("firmware", "version of ArduPilot Copter that the file is of: names and units differ", FIRMWARES)


def read(file: Path, airframe: Airframe, settings: Mapping[str, str]) -> Imported:
    """Return the controller of a file; raises InputError naming file and parameter."""
    dialect = DIALECTS[settings["firmware"]]
    given = read_param(file)
    check_names(given, dialect, file)
    usual = defaults(dialect.table)
    values = usual | given
    rotors = actuation(airframe.vehicle, curve(settings))
    gains = from_ardupilot(values, airframe.vehicle, rotors, dialect, filters(settings))
    shares = added_inertia(values, airframe, settings, dialect)
    if settings[DERIVATIVE.name] == "inertia":
        names = {axis: f"ATC_RAT_{SHORT[axis]}_D" for axis in ATTITUDE_AXES}
        names |= dict.fromkeys(("x", "y"), dialect.names["vxy_d"])
        gains |= {axis: lightened(gains[axis], shares[name]) for axis, name in names.items()}
    tilt, tilt_name = _tilt(values, dialect)
    target = f"ArduPilot Copter {dialect.firmware}"
    accel = held_vertical(values, ardupilot_scales(airframe.vehicle, rotors, values["MOT_THST_EXPO"]), dialect).accel
    notes = (
        f"Read as {target}, with the rotors of the airframe {airframe.name} in the frame that the vehicle is set up with.",
        *absent_note(given, usual, target),
        f"The PI on the vertical acceleration has K = {accel:.3g}; our z gains have the same poles without it.",
        *inertia_note(shares, settings[DERIVATIVE.name] == "inertia"),
        *unused_note(values, _named(dialect, "FF", "vxy_ff", "vz_ff", "az_ff"), "Feed-forward is left out"),
        *unused_note(
            values, _named(dialect, "FLTE", "vxy_flte", "vz_flte"), "Low-pass filters of errors [Hz] are left out"
        ),
        *unused_note(
            values,
            tuple(dialect.names[role] for role in ("vz_i", "vz_d", "az_d")),
            "Terms that our law has not are left out",
        ),
        *tilt_note(tilt, tilt_name),
    )
    return Imported(controller(file, airframe, gains, tilt, settings), (*notes, assumed_note(settings)))


def added_inertia(
    values: Mapping[str, float], airframe: Airframe, settings: Mapping[str, str], dialect: Dialect
) -> dict[str, float]:
    """Return parameter -> share of inertia or mass that its gain on the acceleration adds [1]."""
    vehicle = airframe.vehicle
    scales = ardupilot_scales(vehicle, actuation(vehicle, curve(settings)), values["MOT_THST_EXPO"])
    shares: dict[str, float] = {}
    for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, scales.torque, strict=True):
        name = f"ATC_RAT_{SHORT[axis]}_D"
        shares[name] = values[name] * torque / inertia
    name = dialect.names["vxy_d"]
    return shares | {name: values[name] * scales.horizontal}


def _named(dialect: Dialect, rate_term: str, *roles: str) -> tuple[str, ...]:
    rates = tuple(f"ATC_RAT_{short}_{rate_term}" for short in SHORT.values())
    return (*rates, *(dialect.names[role] for role in roles))


def _tilt(values: Mapping[str, float], dialect: Dialect) -> tuple[float, str]:
    """Return the largest tilt [rad] and the parameter that it comes from."""
    if values["PSC_ANGLE_MAX"] > 0.0:
        return tilt_limit(values), "PSC_ANGLE_MAX"
    name, unit, usual = LEAN[dialect.firmware]
    return radians(unit * values.get(name, usual)), name


IMPORTER = Importer(
    name="ardupilot",
    title="ArduPilot Copter 4.6 or 4.7, parameter file",
    options=(FIRMWARE, control_period("0.0025"), CURVE, ATTITUDE_FILTER, POSITION_FILTER, DERIVATIVE),
    read=read,
)
