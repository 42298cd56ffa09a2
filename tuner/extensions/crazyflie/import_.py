"""Crazyflie: a parameter file of cflib as a controller of ours, the firmware's own attitude loops inside of our PID."""

from collections.abc import Mapping
from dataclasses import replace
from math import radians

from plant.input_files import ReadableFile
from plant.law_registry import law
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.vehicle import Vehicle
from tuner.exchange.target import ImportedController, Importer, Option, number
from tuner.extensions.autopilots.assembly import (
    POSITION_EVERY,
    POSITION_FILTER,
    absent_note,
    by_default,
    control_period,
    filled,
    position_every,
    record_of,
    tilt_note,
    untuned_notes,
)
from tuner.extensions.autopilots.native_loops import with_authorities
from tuner.extensions.autopilots.parameters import defaults
from tuner.extensions.crazyflie.map import HORIZONTAL, NAME, TABLE, TILT, units
from tuner.extensions.crazyflie.native_loops import CARRIED, NATIVE_LAW, check_names, native_held
from tuner.extensions.crazyflie.text import read as read_parameters

FIRMWARE = "crazyflie-firmware 2025"
AIRFRAME = "airframe"
FULL_THRUST = Option(
    "full_thrust", "thrust of one motor at 65535 counts [N]; airframe: that of its largest speed", (), AIRFRAME
)


def full_thrust(vehicle: Vehicle, settings: Mapping[str, str]) -> float:
    """Return the thrust of one motor at 65535 counts [N]."""
    if settings[FULL_THRUST.name] == AIRFRAME:
        return actuation(vehicle).thrust_max
    return number(settings, FULL_THRUST.name, 0.01, 100.0, "N")


def read(file: ReadableFile, airframe: Airframe, settings: Mapping[str, str]) -> ImportedController:
    """Return the controller of a file; raises InputError naming file and parameter."""
    given = read_parameters(file)
    check_names(given, file)
    values, tilt = {**defaults(TABLE), **given}, radians({**defaults(TABLE), **given}[TILT[0]])
    cascade = close_cascade(law("pid"), law(NATIVE_LAW.law), position_every(settings))
    plain = by_default(airframe, cascade, tilt, settings)
    one = units(plain, full_thrust(airframe.vehicle, settings))
    t_f = number(settings, POSITION_FILTER.name, 0.0, 1.0, "s")
    controller = native_held(with_authorities(plain, one.turning), one, values, dict.fromkeys((*HORIZONTAL, "z"), t_f))
    record = record_of(file, "crazyflie", FIRMWARE, settings, given, TABLE, CARRIED)
    untouched = tuple(name for name in given if name not in record.parameters)
    notes = (
        f"Read as {NAME}, with the rotors of the airframe {airframe.name}.",
        *absent_note(given, {name: usual for name, usual in defaults(TABLE).items() if name in CARRIED}, NAME),
        f"The file does not tell the filter of our position loops (taken as {t_f:g} s): give --set {POSITION_FILTER.name}.",
        *tilt_note(tilt, TILT[0]),
        *untuned_notes(record, untouched),
    )
    return ImportedController(replace(filled(controller, {}, file), vehicle=record), notes, untouched)


IMPORTER = Importer(
    name="crazyflie",
    title="Crazyflie, parameter file of cflib (YAML)",
    options=(control_period("0.002"), replace(POSITION_EVERY, default="5"), POSITION_FILTER, FULL_THRUST),
    read=read,
)
