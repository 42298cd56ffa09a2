"""Betaflight from 4.3 on: what its command line prints for `diff` or `dump`, as a PID controller of ours.

Betaflight has no heading loop and no position loops of this form: the former is an option, the latter stand at our defaults.
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from math import degrees

from plant.errors import InputError
from plant.input_files import ReadableFile
from plant.law_registry import law
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.airframes.actuation import Actuation, actuation
from plant.quadrotor.cascade import ATTITUDE_AXES, close_cascade
from tuner.exchange.aboard import DERIVATIVE
from tuner.exchange.target import ImportedController, Importer, Option, number
from tuner.extensions.autopilots.assembly import (
    ATTITUDE_FILTER,
    CURVE,
    LOOPS,
    OUR_LOOPS,
    POSITION_EVERY,
    POSITION_FILTER,
    absent_note,
    assumed_note,
    by_default,
    control_period,
    controller,
    curve,
    filled,
    filters,
    inertia_note,
    position_every,
    settings_note,
    tilt_note,
    unused_note,
)
from tuner.extensions.autopilots.parameters import defaults
from tuner.extensions.autopilots.pid import weighted
from tuner.extensions.betaflight.command_notes import command_notes
from tuner.extensions.betaflight.commands import read_profile
from tuner.extensions.betaflight.map import (
    EXTRA,
    FILTERS,
    NAMES,
    OTHERS,
    RELEASES,
    SWITCHES,
    TABLE,
    USUAL,
    Release,
    betaflight_torque,
    from_betaflight,
    reversed_yaw,
    tilt_limit,
)
from tuner.extensions.betaflight.native_loops import NATIVE_LAW, NATIVE_SWITCHES, NATIVE_TABLE, native_read
from tuner.extensions.betaflight.remainder import (
    native_absent_note,
    native_terms_note,
    remaining_filters_note,
    replaced_low_passes,
    untouched_note,
    untouched_settings,
    vehicle_record,
)
from tuner.extensions.betaflight.rpm_filter import rpm_read
from tuner.extensions.betaflight.text import profile, read_mixer, read_numbers, read_release

# Output per setting D and deg/s2, src/main/flight/pid.h.
D_SCALE = 0.000529
# Names of a release before 2025.12.
OLDEST = RELEASES["4.3"].renamed
MIXERS = ("QUADX", "QUADP")
HEADING = Option("heading_gain", "angle loop around the yaw rate, which Betaflight has not, 1/s", default="2")
# Kinds of I-term relax that our law has, the default first.
SUPPORTED_RELAX = {"iterm_relax": ("RP", "RPY", "OFF"), "iterm_relax_type": ("SETPOINT",)}
PROFILE = Option("profile", "PID profile that is read, 0 to 3", default="0")


def read(file: ReadableFile, airframe: Airframe, settings: Mapping[str, str]) -> ImportedController:
    """Return the controller of a file; raises InputError naming file and setting."""
    stated = read_release(file)
    release = stated or USUAL
    number_of_profile = profile(settings)
    chosen = read_profile(file, number_of_profile)
    texts = renamed(chosen.values, release, stated is not None, file)
    check_law(texts, read_mixer(file), file)
    numbers = read_numbers(texts, NATIVE_TABLE, stated, file)
    given = {name: value for name, value in numbers.items() if name in TABLE}
    usual = defaults(TABLE) | {name: float(text) for name, text in release.usual.items() if name in TABLE}
    values = lower_d(usual | given, release)
    vehicle = airframe.vehicle
    rotors = actuation(vehicle, curve(settings))
    heading = number(settings, HEADING.name, 0.01, 50.0, "1/s")
    gains = from_betaflight(values, vehicle, rotors, filters(settings), heading)
    shares = {
        NAMES[axis].d: values[NAMES[axis].d] * D_SCALE * degrees(torque / inertia)
        for axis, inertia, torque in zip(ATTITUDE_AXES, vehicle.inertia, betaflight_torque(rotors), strict=True)
    }
    if settings[DERIVATIVE.name] == "inertia":
        gains = {axis: weighted(loop, 1.0 / (1.0 + shares[NAMES[axis].d])) for axis, loop in gains.items()}
    tilt = tilt_limit(values)
    called = {current: old for old, current in release.renamed.items()}
    terms = tuple(name for name in EXTRA if name in TABLE and not name.startswith("d_"))
    name = f"Betaflight {release.name}"
    notes = (
        f"Read as {name}, with the rotors of the airframe {airframe.name} and their slope at hover.",
        *(
            ()
            if stated
            else (f"The file does not say by which version it was printed: names and defaults are those of {name}.",)
        ),
        f"The heading loop is {heading:g} 1/s, as set; the position loops stand at our defaults: Betaflight has neither.",
        *absent_note(
            {called.get(one, one): 0.0 for one in texts}, {called.get(one, one): usual[one] for one in usual}, name
        ),
        *inertia_note(shares, settings[DERIVATIVE.name] == "inertia"),
        *unused_note(values, terms, "Terms that our law has not are left out"),
        *_switches(texts),
        *_others(texts, release),
        *_turning(texts, rotors),
        *_filters(texts),
        *tilt_note(tilt, called.get("angle_limit", "angle_limit")),
    )
    is_native = settings[LOOPS.name] != OUR_LOOPS
    record = vehicle_record(file, name, settings, texts, is_native)
    untouched = untouched_settings(texts)
    listed = (
        *command_notes(file, number_of_profile, chosen, release.name),
        *untouched_note(untouched, texts),
    )
    if not is_native:
        flown = replace(controller(file, airframe, gains, tilt, settings), vehicle=record)
        return ImportedController(flown, (*notes, *listed, assumed_note(settings)), untouched)
    every = defaults(NATIVE_TABLE) | numbers | values
    native_controller = by_default(
        airframe, close_cascade(law("pid"), law(NATIVE_LAW.law), position_every(settings)), tilt, settings
    )
    native_controller = filled(native_read(native_controller, every, texts, rotors), {}, file)
    options, notch_notes = rpm_read(native_controller.options, every, texts)
    native_notes = (
        *notes[: 1 if stated else 2],
        *native_absent_note(texts, usual, called, name),
        *native_terms_note(values, called),
        *replaced_low_passes(texts, every),
        *remaining_filters_note(texts),
        *(note for note in (*_turning(texts, rotors), *_others(texts, release))),
        *_not_first_order(texts),
        *_other_relax(texts),
        *notch_notes,
        *listed,
    )
    return ImportedController(replace(native_controller, options=options, vehicle=record), native_notes, untouched)


def _not_first_order(texts: Mapping[str, str]) -> tuple[str, ...]:
    """Return a sentence on unsupported low-passes and notches."""
    usual = {name: text for name, (_, text) in NATIVE_SWITCHES.items() if name.endswith(("lpf1_type", "lpf2_type"))}
    others = _deviations(texts, usual | {"gyro_notch2_hz": "0", "dterm_notch_hz": "0"})
    return settings_note("Our low-passes are of first order, and there is one notch", others, " flies otherwise")


def _other_relax(texts: Mapping[str, str]) -> tuple[str, ...]:
    """Return a sentence on another kind of I-term relax than ours."""
    given = {name: texts.get(name, supported[0]) for name, supported in SUPPORTED_RELAX.items()}
    others = {name: text for name, text in given.items() if text not in SUPPORTED_RELAX[name]}
    return settings_note("Our I-term relax is SETPOINT of RP or RPY", others, " flies otherwise")


def renamed(texts: Mapping[str, str], release: Release, stated: bool, file: ReadableFile) -> dict[str, str]:
    """Return the settings by the names of 2025.12; raises InputError where one has a name that the release does not know."""
    for old, current in OLDEST.items() if release.current else ():
        if old in texts and old not in TABLE:
            source = f"the file is of {release.name}" if stated else "the file names no version"
            message = (
                f"is a setting of Betaflight before 2025.12, now {current}, and {source}: give it with its line "
                "'# Betaflight / ...'"
            )
            raise InputError(message, file=file, key=old)
    return {release.renamed.get(name, name): text for name, text in texts.items()}


def lower_d(values: dict[str, float], release: Release) -> dict[str, float]:
    """Return the settings with the D gain that acts at rest: before 2025.12 a d_min of 0, or above d, was switched off."""
    if release.current:
        return values
    lowered = dict(values)
    for axis in ATTITUDE_AXES:
        names = NAMES[axis]
        if not 0.0 < values[names.d] < values[names.d_max]:
            lowered[names.d] = values[names.d_max]
    return lowered


def check_law(texts: Mapping[str, str], mixer: str | None, file: ReadableFile) -> None:
    """Refuse ADRC, integrated yaw and other vehicles than quads; raises InputError naming the setting."""
    if texts.get("pid_type", "CLASSIC") != "CLASSIC":
        message = (
            f"given {texts['pid_type']}; only pid_type = CLASSIC can be read as a PID; `tuner adrc FILE` takes ADRC"
        )
        raise InputError(message, file=file, key="pid_type")
    if texts.get("use_integrated_yaw", "OFF") != "OFF":
        message = "given ON; integrated yaw is another law than PID: set it OFF on the vehicle and give the file again"
        raise InputError(message, file=file, key="use_integrated_yaw")
    if mixer is not None and mixer not in MIXERS:
        message = (
            f"given {mixer}; only {' and '.join(MIXERS)} can be read: our vehicles have four rotors in an X or a plus"
        )
        raise InputError(message, file=file, key="mixer")


def _switches(texts: Mapping[str, str]) -> tuple[str, ...]:
    given = {name: texts.get(name, usual) for name, (_, usual) in SWITCHES.items()}
    active = {name: text for name, text in given.items() if text != SWITCHES[name][0]}
    return settings_note("Switches that change the loops, or the gains, besides those read", active)


def _others(texts: Mapping[str, str], release: Release) -> tuple[str, ...]:
    """Return a sentence on other settings that differ from the release's defaults."""
    usual = OTHERS | {name: text for name, text in release.usual.items() if name not in TABLE}
    what = "Our loops cannot carry these; an export leaves them as they are"
    return settings_note(what, _deviations(texts, usual))


def _deviations(texts: Mapping[str, str], usual: Mapping[str, str]) -> dict[str, str]:
    return {name: texts[name] for name, text in usual.items() if texts.get(name, text) != text}


def _turning(texts: Mapping[str, str], rotors: Actuation) -> tuple[str, ...]:
    """Return a sentence where the rotors' sense differs from the airframe's."""
    given, ours = texts.get("yaw_motors_reversed", "OFF"), reversed_yaw(rotors)
    if given == ours:
        return ()
    return (
        f"yaw_motors_reversed = {given} turns every rotor against that of the airframe, which goes with {ours}: correct spin in "
        "the airframe's file, or the loops on yaw that are flown here are those of another vehicle.",
    )


def _filters(texts: Mapping[str, str]) -> tuple[str, ...]:
    filters = {name: text for name, text in texts.items() if re.fullmatch(FILTERS, name)}
    return settings_note("Filters and loop rate of the vehicle, which our loops have not and an export leaves", filters)


IMPORTER = Importer(
    name="betaflight",
    title="Betaflight 4.3 to 2026.12, what the command line prints for diff or dump",
    options=(
        PROFILE,
        HEADING,
        control_period("0.001"),
        LOOPS,
        POSITION_EVERY,
        CURVE,
        ATTITUDE_FILTER,
        POSITION_FILTER,
        DERIVATIVE,
    ),
    read=read,
)
