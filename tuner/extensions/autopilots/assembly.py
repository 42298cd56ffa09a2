"""From gains by axis to a controller: what every importer does once it has them."""

from collections.abc import Collection, Iterable, Mapping
from math import degrees
from typing import Any

from plant.errors import InputError, shortened
from plant.input_files import ReadableFile, file_sha256
from plant.law_registry import law
from plant.laws.pid import Gains
from plant.laws.slower import MAX_PERIODS
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.cascade import ATTITUDE_AXES, AXES, Cascade, close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions
from tuner.exchange.aboard import plain_name
from tuner.exchange.target import Option, number, whole_number
from tuner.extensions.autopilots.pid import held_tilt, with_gains
from tuner.gains import Controller, VehicleRecord
from tuner.gains.ranges import LONGEST, SHORTEST, check_value, usual_timing

OF_AIRFRAME = "airframe"
CURVE = Option(
    "thrust_curve",
    "factor f of the rotors' thrust T = T_max (f u^2 + (1 - f) u) of the command u, 0 to 1, or airframe: 1 - thrust_linear",
    default=OF_AIRFRAME,
)
ATTITUDE_FILTER = Option(
    "attitude_filter", "time constant t_f of our derivative filter in the attitude loops, s", default="0.005"
)
POSITION_FILTER = Option(
    "position_filter", "time constant t_f of our derivative filter in the position loops, s", default="0.01"
)
NATIVE_LOOPS, OUR_LOOPS = "own", "pid"
LOOPS = Option(
    "loops",
    "own: the autopilot's own loops, filters included, parameter by parameter; pid: our PID with the same feedback, without them",
    (OUR_LOOPS, NATIVE_LOOPS),
    OUR_LOOPS,
)
POSITION_EVERY = Option(
    "position_every", "periods of the controller between two steps of own position loops, 1 to 64", default="8"
)


def position_every(settings: Mapping[str, str]) -> int:
    """Return the period of native position loops [control periods]."""
    return whole_number(settings, POSITION_EVERY.name, 1, MAX_PERIODS)


def control_period(default: str) -> Option:
    """Return the option of the control period, with the target's default [s]."""
    return Option("control_period", "period of our controller, s", default=default)


def curve(settings: Mapping[str, str]) -> float | None:
    """Return the factor of the thrust curve, None for the airframe's."""
    return None if settings[CURVE.name] == OF_AIRFRAME else number(settings, CURVE.name, 0.0, 1.0, "1")


def filters(settings: Mapping[str, str]) -> dict[str, float]:
    """Return the time constant of the derivative filter by axis [s]."""
    attitude = number(settings, ATTITUDE_FILTER.name, 0.0, 1.0, "s")
    position = number(settings, POSITION_FILTER.name, 0.0, 1.0, "s")
    return {axis: attitude if axis in ATTITUDE_AXES else position for axis in AXES}


def assumed_note(settings: Mapping[str, str], tells_period: bool = False) -> str:
    """Return the sentence on what a parameter file lacks; tells_period: it has our control period."""
    period = "" if tells_period else f"our control period (taken as {settings['control_period']} s) and "
    return (
        f"The file does not tell {period}our derivative filters "
        f"({settings[ATTITUDE_FILTER.name]} s in the attitude, {settings[POSITION_FILTER.name]} s in the position loops): "
        f"give --set {'' if tells_period else 'control_period, '}attitude_filter, position_filter."
    )


def controller(
    file: ReadableFile, airframe: Airframe, gains: Mapping[str, Gains], tilt: float, settings: Mapping[str, str]
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


def filled(controller: Controller, gains: Mapping[str, Any], file: ReadableFile) -> Controller:
    """Return the controller with the gains of some axes; raises InputError naming file and invalid gain."""
    controller = with_gains(controller, gains)
    for gain in gain_addresses(controller.cascade):
        try:
            check_value(gain.address, gain, controller.gains[gain.column], controller.control_period)
        except InputError as error:
            raise error.located(file=file) from None
    return controller


def version_note(version: str | None, target: str, read_as: Collection[str]) -> tuple[str, ...]:
    """Return a sentence where a file names an unexpected version; version: as stated, None if not."""
    if version is None or any(version == prefix or version.startswith(f"{prefix}.") for prefix in read_as):
        return ()
    return (
        f"The file is of version {shortened(version)}, and is read with the names, units and defaults of {target}: check the "
        "names of that version.",
    )


def tilt_note(tilt: float, name: str) -> tuple[str, ...]:
    """Return a sentence where a tilt [rad] is cut."""
    limit = held_tilt(tilt)
    if limit == tilt:
        return ()
    return (f"{name} = {degrees(tilt):.3g} deg is cut to {degrees(limit):.3g} deg, the limit of ours.",)


def absent_note(values: Mapping[str, float | str], wanted: Mapping[str, float | str], target: str) -> tuple[str, ...]:
    """Return a sentence on missing parameters and their defaults."""
    given = {name: value if isinstance(value, str) else f"{value:g}" for name, value in wanted.items()}
    missing = {name: text for name, text in given.items() if name not in values}
    return settings_note(f"Not in the file, so at the default of {target}", missing)


def settings_note(what: str, settings: Mapping[str, str], end: str = "") -> tuple[str, ...]:
    """Return a sentence that lists settings, none without settings."""
    text = ", ".join(f"{name} = {value}" for name, value in settings.items())
    return (f"{what}: {text}{end}.",) if settings else ()


def inertia_note(shares: Mapping[str, float], counted: bool) -> tuple[str, ...]:
    """Return a sentence on derivative gains; shares: parameter -> share of the inertia that its gain adds [1]."""
    entries = [f"{name} ({100.0 * share:.3g} %)" for name, share in shares.items() if share != 0.0]
    if not entries:
        return ()
    what = "count as added inertia or mass" if counted else "are left out"
    return (
        f"Our law has no derivative on the acceleration: {what}, with the inertia or mass that they add: {', '.join(entries)}.",
    )


def unused_note(values: Mapping[str, float], names: Iterable[str], what: str) -> tuple[str, ...]:
    """Return a sentence on the parameters that are not 0."""
    return settings_note(what, {name: f"{values[name]:g}" for name in names if values.get(name, 0.0) != 0.0})


def record_of(
    file: ReadableFile,
    target: str,
    version: str,
    settings: Mapping[str, str],
    given: Mapping[str, float],
    loop_parameters: Collection[str],
    carried: Collection[str],
) -> VehicleRecord:
    """Return the record of a file; given: all parameters; loop_parameters: those that act in the loops."""
    entries = {name: given[name] for name in loop_parameters if name in given}
    untuned = tuple(name for name in entries if name not in carried)
    digest = file_sha256(file)
    return VehicleRecord(target, version, plain_name(file), digest, dict(settings), entries, untuned)


def untuned_notes(record: VehicleRecord, untouched: Collection[str]) -> tuple[str, ...]:
    """Return sentences on parameters that our loops cannot carry, or unrelated."""
    what = "Our loops cannot carry these, so nothing tunes them and an export leaves them as they are"
    notes = [*settings_note(what, {name: f"{record.parameters[name]:g}" for name in record.untuned})]
    if untouched:
        notes.append(
            f"{len(untouched)} other parameter{'s' if len(untouched) > 1 else ''} of the file do not act in these loops; "
            "an export does not write them."
        )
    return tuple(notes)
