"""ArduPilot Copter 4.6 and 4.7: a parameter file as a PID controller of ours, on an airframe that the file does not describe.

Files of Copter 3.3 to 4.5 are read as 4.6, under the names that the firmware's own update gives their parameters.
"""

from collections.abc import Mapping

from plant.errors import InputError
from plant.input_files import ReadableFile
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.airframes.actuation import actuation
from tuner.exchange.aboard import DERIVATIVE
from tuner.exchange.target import FIRMWARE, ImportedController, Importer, Option
from tuner.extensions.ardupilot.map import ArduPilot
from tuner.extensions.ardupilot.other_files import resolved
from tuner.extensions.ardupilot.ranges import AROUND, DIALECTS, FIRMWARES, SHORT, Dialect, check_names
from tuner.extensions.ardupilot.text import OLDER, WHAT, Modern, modernized, read_param
from tuner.extensions.autopilots.assembly import (
    ATTITUDE_FILTER,
    CURVE,
    LOOPS,
    POSITION_FILTER,
    absent_note,
    curve,
    unused_note,
    version_note,
)
from tuner.extensions.autopilots.cascade import ParameterFile, cascade_for, imported
from tuner.extensions.autopilots.parameters import defaults, stated
from tuner.extensions.autopilots.resolution import plain_file
from tuner.gains.ranges import LONGEST, SHORTEST

VERSION = Option(FIRMWARE, "version of ArduPilot Copter that the file is of: names and units differ", FIRMWARES)
LOOP_RATE, USUAL_RATE = "SCHED_LOOP_RATE", 400.0
# Control period that stands for the file's loop rate.
PERIOD, OF_FILE = "control_period", "0"
LOOP_PERIOD = Option(
    PERIOD,
    f"period of our controller, s; 0: that of {LOOP_RATE} in the file, 0.0025 where it is not there",
    default=OF_FILE,
)
# Versions that a firmware's names and units hold for.
READ_AS = {"4.6": ("4.5", "4.6"), "4.7": ("4.7", "4.8")}


def read(file: ReadableFile, airframe: Airframe, settings: Mapping[str, str]) -> ImportedController:
    """Return the controller of a file; raises InputError naming file and parameter."""
    dialect = DIALECTS[settings[FIRMWARE]]
    other = resolved(file)
    file = plain_file(file, other)
    plain = read_param(file)
    check_names(plain, dialect, file)
    version = stated(file, WHAT).version
    check_version(version, dialect, file)
    modern = modernized(plain, file)
    check_age(modern, dialect, file)
    given, target = modern.values, _target(dialect, modern)
    requested, settings = settings, _timed(settings, given, file)
    cascade = cascade_for(dialect, settings)
    ardupilot = ArduPilot(dialect.flying(cascade), airframe.vehicle, actuation(airframe.vehicle, curve(settings)))
    values = ardupilot.completed(given)
    accel = ardupilot.vertical(values).accel
    carried = ardupilot.version.carried
    feed, filters = (
        [name for name in _named(dialect, *terms) if name not in carried]
        for terms in (("FF", "vxy_ff", "vz_ff", "az_ff"), ("FLTE", "vxy_flte", "vz_flte"))
    )
    notes = (
        *(() if other is None else other.notes),
        f"Read as {target}, with the rotors of the airframe {airframe.name} in the frame that the vehicle is set up with.",
        *version_note(version, target, READ_AS[dialect.firmware]),
        *_old_notes(modern),
        *absent_note(given, defaults(dialect.table), dialect.name),
        f"The PI on the vertical acceleration has K = {accel:.3g}; our z gains have the same poles without it.",
        *_rate_note(requested, given),
    )
    later_notes = (
        *unused_note(values, feed, "Feed-forward is left out"),
        *unused_note(values, filters, "Low-pass filters of errors [Hz] are left out"),
        *unused_note(values, dialect.named("vz_i", "vz_d", "az_d"), "Terms that our law has not are left out"),
    )
    loop_parameters = [name for name in given if name in dialect.table or name.startswith(AROUND)]
    has_period = requested[PERIOD] == OF_FILE and LOOP_RATE in given
    described = ParameterFile(file, given, target, loop_parameters, notes, later_notes, tells_period=has_period)
    return imported(ardupilot, described, airframe, cascade, settings, values)


def _timed(settings: Mapping[str, str], given: Mapping[str, float], file: ReadableFile) -> Mapping[str, str]:
    """Return the settings with the file's control period, where none is set."""
    if settings[PERIOD] != OF_FILE:
        return settings
    rate = given.get(LOOP_RATE, USUAL_RATE)
    if not 1.0 / LONGEST <= rate <= 1.0 / SHORTEST:
        raise InputError(
            f"given {rate:g} Hz; loops of {1.0 / LONGEST:g} to {1.0 / SHORTEST:g} Hz can be read",
            file=file,
            key=LOOP_RATE,
        )
    return {**settings, PERIOD: f"{1.0 / rate:.9g}"}


def _rate_note(requested: Mapping[str, str], given: Mapping[str, float]) -> tuple[str, ...]:
    """Return a sentence on the loop rate of the file."""
    if LOOP_RATE not in given:
        return ()
    rate = f"{LOOP_RATE} = {given[LOOP_RATE]:g} Hz"
    if requested[PERIOD] == OF_FILE:
        return (f"The control period is that of {rate}.",)
    return (f"The control period is {requested[PERIOD]} s as set, and {rate} of the file is not.",)


def check_version(version: str | None, dialect: Dialect, file: ReadableFile) -> None:
    """Refuse a file that says to be of the other dialect; version: as it says, None if silent."""
    digits = [] if version is None else version.split(".")[:2]
    if len(digits) < 2 or not all(digit.isdecimal() for digit in digits):
        return
    fitting = "4.6" if (int(digits[0]), int(digits[1])) < (4, 7) else "4.7"
    if fitting != dialect.firmware:
        read_as = f"and the file is read as {dialect.firmware}: units differ by up to 1000"
        message = f"says {version}, {read_as}; give --firmware {fitting}"
        raise InputError(message, file=file, key="# Version")


def check_age(modern: Modern, dialect: Dialect, file: ReadableFile) -> None:
    """Raise InputError for names from before 4.0 in a file of 4.7."""
    if modern.renamed and dialect.firmware != "4.6":
        old = next(iter(modern.renamed))
        message = "is a name from before Copter 4.0; give --firmware 4.6, whose names and units it is turned into"
        raise InputError(message, file=file, key=old)


def _target(dialect: Dialect, modern: Modern) -> str:
    """Return the name of the file's version in records."""
    return f"ArduPilot Copter {OLDER} as {dialect.firmware}" if modern.renamed else dialect.name


def _old_notes(modern: Modern) -> tuple[str, ...]:
    """Return sentences on names of older versions."""
    notes = []
    if modern.renamed:
        renames = ", ".join(f"{old} -> {' and '.join(new)} = {value:g}" for old, (value, new) in modern.renamed.items())
        notes.append(
            f"Names from before Copter 4.0 are read as the firmware's own update turns them: {renames}. Rate gains of 3.3 are "
            "multiplied by 0.9 (frames X, V, H) or 1.27; defaults of what is missing are those of 4.6, not of that version."
        )
    if modern.unknown:
        notes.append(
            "Not read, because the units of their version are not known here: " + ", ".join(modern.unknown) + "."
        )
    return tuple(notes)


def _named(dialect: Dialect, rate_term: str, *roles: str) -> tuple[str, ...]:
    return (*(f"ATC_RAT_{short}_{rate_term}" for short in SHORT.values()), *dialect.named(*roles))


IMPORTER = Importer(
    name="ardupilot",
    title="ArduPilot Copter 4.6 or 4.7, parameter file",
    options=(VERSION, LOOP_PERIOD, LOOPS, CURVE, ATTITUDE_FILTER, POSITION_FILTER, DERIVATIVE),
    read=read,
)
