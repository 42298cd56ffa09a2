"""From gains by axis to a controller: what every importer does once it has them."""

import hashlib
from collections.abc import Collection, Iterable, Mapping
from math import degrees
from pathlib import Path
from typing import Any

from plant.airframes import Airframe
from plant.cascade import ATTITUDE_AXES, AXES, Cascade, close_cascade
from plant.errors import InputError, shortened
from plant.gains import default_row, gain_addresses
from plant.input_files import read_input
from plant.laws import law
from plant.laws.pid import Gains
from plant.laws.slower import MOST_PERIODS
from plant.nominal import ControlOptions
from tuner.exchange.aboard import plain_name
from tuner.exchange.autopilot.pid import held_tilt, with_gains
from tuner.exchange.target import Option, number
from tuner.gains import Controller, VehicleRecord
from tuner.gains.ranges import LONGEST, SHORTEST, check_value, usual_timing

CURVE = Option(
    "thrust_curve", "factor f of the rotors' thrust T = T_max (f u^2 + (1 - f) u) of the command u, 0 to 1", default="1"
)
ATTITUDE_FILTER = Option(
    "attitude_filter", "time constant t_f of our derivative filter in the attitude loops, s", default="0.005"
)
POSITION_FILTER = Option(
    "position_filter", "time constant t_f of our derivative filter in the position loops, s", default="0.01"
)
OWN_LOOPS, OUR_LOOPS = "own", "pid"
LOOPS = Option(
    "loops",
    "own: the autopilot's own loops, filters included, parameter by parameter; pid: our PID with the same feedback, without them",
    (OUR_LOOPS, OWN_LOOPS),
    OUR_LOOPS,
)
POSITION_EVERY = Option(
    "position_every", "periods of the controller between two steps of own position loops, 1 to 64", default="8"
)


def position_every(settings: Mapping[str, str]) -> int:
    """Return how often own position loops step [control periods]."""
    every = number(settings, POSITION_EVERY.name, 1.0, MOST_PERIODS, "1")
    if every != int(every):
        raise InputError(
            f"given {every:g}; this must be a whole number from 1 to {MOST_PERIODS}", key="--set position_every"
        )
    return int(every)


def control_period(default: str) -> Option:
    """Return the option of the control period with the target's usual one [s]."""
    return Option("control_period", "period of our controller, s", default=default)


def curve(settings: Mapping[str, str]) -> float:
    """Return the factor of the thrust curve [1]."""
    return number(settings, CURVE.name, 0.0, 1.0, "1")


def filters(settings: Mapping[str, str]) -> dict[str, float]:
    """Return the time constant of the derivative filter by axis [s]."""
    attitude = number(settings, ATTITUDE_FILTER.name, 0.0, 1.0, "s")
    position = number(settings, POSITION_FILTER.name, 0.0, 1.0, "s")
    return {axis: attitude if axis in ATTITUDE_AXES else position for axis in AXES}


def assumed_note(settings: Mapping[str, str], tells_period: bool = False) -> str:
    """Return the sentence about what a parameter file does not tell; tells_period: it has our control period."""
    period = "" if tells_period else f"our control period (taken as {settings['control_period']} s) and "
    return (
        f"The file does not tell {period}our derivative filters "
        f"({settings[ATTITUDE_FILTER.name]} s in the attitude, {settings[POSITION_FILTER.name]} s in the position loops): "
        f"give --set {'' if tells_period else 'control_period, '}attitude_filter, position_filter."
    )


def controller(
    file: Path, airframe: Airframe, gains: Mapping[str, Gains], tilt: float, settings: Mapping[str, str]
) -> Controller:
    """Return a PID controller; axes without gains have the law's defaults. tilt: largest [rad], cut to what we know.

    Raises InputError naming file and gain where one is outside of what our law takes.
    """
    return filled(by_default(airframe, close_cascade(law("pid"), law("pid")), tilt, settings), gains, file)


def by_default(airframe: Airframe, cascade: Cascade, tilt: float, settings: Mapping[str, str]) -> Controller:
    """Return a controller with default gains; tilt: largest [rad], cut to what we know."""
    period = number(settings, "control_period", SHORTEST, LONGEST, "s")
    row = tuple(default_row(cascade, airframe.vehicle))
    options = ControlOptions(tilt_limit=held_tilt(tilt))
    return Controller(airframe, cascade, options, period, usual_timing(period, airframe).plant_step, row)


def filled(found: Controller, gains: Mapping[str, Any], file: Path) -> Controller:
    """Return the controller with the gains of some axes; raises InputError naming file and gain where a law does not take one."""
    found = with_gains(found, gains)
    for gain in gain_addresses(found.cascade):
        try:
            check_value(gain.address, gain, found.gains[gain.column], found.control_period)
        except InputError as error:
            raise error.located(file=file) from None
    return found


def version_note(version: str | None, target: str, read_as: Collection[str]) -> tuple[str, ...]:
    """Return a sentence where a file names another version than those that it is read as; version: as it says, None if silent."""
    if version is None or any(version == own or version.startswith(f"{own}.") for own in read_as):
        return ()
    return (
        f"The file says version {shortened(version)}, and is read with the names, units and defaults of {target}: check what "
        "that version calls them.",
    )


def tilt_note(tilt: float, name: str) -> tuple[str, ...]:
    """Return a sentence where a tilt [rad] is cut."""
    limit = held_tilt(tilt)
    if limit == tilt:
        return ()
    return (f"{name} = {degrees(tilt):.3g} deg is cut to {degrees(limit):.3g} deg, the limit of ours.",)


def absent_note(values: Mapping[str, float | str], wanted: Mapping[str, float | str], target: str) -> tuple[str, ...]:
    """Return a sentence that names what the file lacks and the defaults that are taken instead."""
    missing = [f"{name} = {_text(value)}" for name, value in wanted.items() if name not in values]
    return (f"Not in the file, so at the default of {target}: {', '.join(missing)}.",) if missing else ()


def _text(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def inertia_note(shares: Mapping[str, float], counted: bool) -> tuple[str, ...]:
    """Return a sentence on derivative gains; shares: parameter -> share of the inertia that its gain adds [1]."""
    there = [f"{name} ({100.0 * share:.3g} %)" for name, share in shares.items() if share != 0.0]
    if not there:
        return ()
    what = "count as added inertia or mass" if counted else "are left out"
    return (
        f"Our law has no derivative on the acceleration: {what}, with the inertia or mass that they add: {', '.join(there)}.",
    )


def unused_note(values: Mapping[str, float], names: Iterable[str], what: str) -> tuple[str, ...]:
    """Return a sentence that names the parameters among some that are not 0."""
    there = [f"{name} = {values[name]:g}" for name in names if values.get(name, 0.0) != 0.0]
    return (f"{what}: {', '.join(there)}.",) if there else ()


def record_of(
    file: Path,
    target: str,
    version: str,
    settings: Mapping[str, str],
    given: Mapping[str, float],
    known: Collection[str],
    carried: Collection[str],
) -> VehicleRecord:
    """Return the record of a file; given: all of its parameters; known: those that act in the loops, of which ours carry some."""
    there = {name: given[name] for name in known if name in given}
    kept = tuple(name for name in there if name not in carried)
    digest = hashlib.sha256(read_input(file)).hexdigest()
    return VehicleRecord(target, version, plain_name(file), digest, dict(settings), there, kept)


def kept_notes(record: VehicleRecord, untouched: Collection[str]) -> tuple[str, ...]:
    """Return sentences that name what our loops cannot carry, and count what has nothing to do with them."""
    notes = []
    if record.kept:
        there = ", ".join(f"{name} = {record.parameters[name]:g}" for name in record.kept)
        notes.append(
            f"Our loops cannot carry these, so nothing tunes them and an export leaves them as they are: {there}."
        )
    if untouched:
        notes.append(
            f"{len(untouched)} other parameter{'s' if len(untouched) > 1 else ''} of the file do not act in these loops; "
            "an export does not write them."
        )
    return tuple(notes)
