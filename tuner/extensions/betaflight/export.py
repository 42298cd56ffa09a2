"""Betaflight 2025.12: our attitude PID as a file for its command line.

Rate loops PI with the level strength (angle mode) around roll and pitch, in whole numbers; heading and position have no loop that
could be carried. src/main/flight/pid.c, mixer.c.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import degrees

from plant.errors import InputError, shortened
from plant.quadrotor.airframes.actuation import Actuation, actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.exchange.target import Bundle, ExportTarget, HeldParameter, Option, Request
from tuner.exchange.texts import heading, parameter_comment
from tuner.extensions.autopilots import pid
from tuner.extensions.autopilots.assembly import CURVE, curve
from tuner.extensions.autopilots.parameters import ParameterInfo, defaults, option_changes, parameters
from tuner.extensions.autopilots.scales import Motors, command_slope, motors_text
from tuner.extensions.betaflight import native_loops
from tuner.extensions.betaflight.commands import read_cli
from tuner.extensions.betaflight.import_ import IMPORTER
from tuner.extensions.betaflight.map import (
    ANGLE_LIMIT,
    EXTRA,
    LEVEL,
    SWITCHES,
    TABLE,
    from_betaflight,
    loops,
    reversed_yaw,
    tilt_limit,
    to_betaflight,
)
from tuner.extensions.betaflight.rpm_filter import with_notches
from tuner.extensions.betaflight.text import (
    parse_integer,
    profile,
    read_numbers,
    read_release,
    read_selected,
    write_cli,
)
from tuner.gains import Controller

FILE = "gainproof.betaflight.txt"
NAME = "Betaflight 2025.12"
# Its numbers of our rotors 1 to 4, mixers QUADX and QUADP.
MOTORS: Motors = (4, 2, 3, 1)
# Our largest tilt limit [rad].
MAX_TILT = 1.05
LOADING = (
    "Load all of it on the command line: it is stored whole or not at all. An error is a line that begins with three hash signs; "
    "nothing is stored then, and 'exit' brings back what was."
)
ABOUT = f"For {NAME} to 2026.12. {LOADING}"

OPTIONS = (CURVE, Option("profile", "PID profile that is written, 0 to 3", default="0"))


def export(request: Request) -> Bundle:
    """Return the file; raises InputError where the gains have no form in Betaflight or leave its ranges."""
    requested = pid.with_measured_rates(request.controller)
    rotors = actuation(requested.airframe.vehicle, curve(request.settings))
    if native_loops.NATIVE_LAW.flies_attitude(requested):
        return native_export(request, requested, rotors)
    given = previous_numbers(request)
    before = {} if request.previous is None else defaults(TABLE) | given
    check_level(requested, rotors, before)
    wanted = to_betaflight(requested, rotors, before)
    unchanged = stays(wanted, before)
    changing = {name: wanted[name] for name in wanted if name not in unchanged}
    written = parameters(TABLE, changing, nearest, NAME, given or imported_numbers(request))
    check_rounding(written)
    held = held_controller(requested, {parameter.name: parameter.held for parameter in written}, rotors, before)
    differences = _differences(requested, written, rotors, before, unchanged, request)
    switches = {name: choice for name, choice in SWITCHES.items() if name not in unchanged}
    return bundle(request, rotors, NAME, ABOUT, TABLE, switches, written, held, differences)


def native_export(request: Request, requested: Controller, rotors: Actuation) -> Bundle:
    """Return the file of Betaflight's own loops; raises InputError where a gain leaves the range of its setting."""
    given = previous_numbers(request) or imported_numbers(request)
    wanted = {**native_loops.native_settings(requested, rotors), ANGLE_LIMIT: degrees(requested.options.tilt_limit)}
    written = parameters(native_loops.NATIVE_TABLE, wanted, nearest, NAME, given)
    check_rounding(written)
    values = {parameter.name: parameter.held for parameter in written}
    held, switches = native_loops.native_held(requested, values, rotors), native_loops.native_switches(requested)
    held = replace(held, options=replace(with_notches(requested.options, values), tilt_limit=tilt_limit(values)))
    changes = option_changes(native_loops.NATIVE_TABLE, written) if given else ()
    differences = (*changes, *pid.rate_sources(request.controller), *native_loops.native_differences(requested))
    written_file = bundle(request, rotors, NAME, ABOUT, native_loops.NATIVE_TABLE, switches, written, held, differences)
    return replace(written_file, notches=True)


def bundle(
    request: Request,
    rotors: Actuation,
    name: str,
    about: str,
    table: Mapping[str, ParameterInfo],
    switches: Mapping[str, tuple[str, str]],
    written: tuple[HeldParameter, ...],
    held: Controller,
    differences: tuple[str, ...],
) -> Bundle:
    """Return the file of rounded parameters and switches, with its rollback."""
    values = {parameter.name: parameter.held for parameter in written}
    comments = (
        *heading(request, parameter_comment),
        about,
        f"Expected of the vehicle: {motors_text(rotors, MOTORS)}; yaw_motors_reversed = {reversed_yaw(rotors)}.",
    )
    files = {FILE: write_cli(settings(values, switches), profile(request.settings), comments)}
    return Bundle(files, {FILE: rollback(request, table, switches, values)}, held, differences, name, written)


def imported_numbers(request: Request) -> Mapping[str, float]:
    """Return a vehicle's numbers at the import, nothing without one."""
    record = request.controller.vehicle
    return {} if request.previous is not None or record is None or record.target != TARGET.name else record.parameters


def previous_numbers(request: Request) -> dict[str, float]:
    """Return a vehicle's numbers from its file, nothing where none is given.

    Raises InputError where the file is of a release with other names, or has what no PID of ours is.
    """
    if request.previous is None:
        return {}
    file, texts = request.previous, read_cli(request.previous, profile(request.settings))
    release = read_release(file)
    if release is not None and not release.current:
        message = (
            f"was printed by Betaflight {release.name}, whose settings are others than those of {NAME}: bring the firmware up to "
            "date, then give its file"
        )
        raise InputError(message, file=file, key="version")
    if (integrated := texts.get("use_integrated_yaw", "OFF")) != "OFF":
        law = "integrated yaw is another law than PID"
        message = f"given {shortened(integrated)}; {law}: set it OFF on the vehicle and give its file again"
        raise InputError(message, file=file, key="use_integrated_yaw")
    return read_numbers(texts, native_loops.NATIVE_TABLE, release, file)


def stays(wanted: Mapping[str, float], before: Mapping[str, float]) -> tuple[str, ...]:
    """Return the settings that a vehicle retains: terms that our law lacks, and a tilt limit beyond ours."""
    if not before:
        return ()
    beyond = before[ANGLE_LIMIT] > wanted[ANGLE_LIMIT] >= nearest(degrees(MAX_TILT))
    return (*EXTRA, ANGLE_LIMIT) if beyond else EXTRA


def nearest(value: float) -> float:
    """Round to a whole number."""
    return float(round(value))


def settings(values: Mapping[str, float], switches: Mapping[str, tuple[str, str]]) -> dict[str, str]:
    """Return everything that is set, as text; switches first, for the sliders overwrite gains while they are on."""
    return {name: choice for name, (choice, _) in switches.items()} | {
        name: f"{int(value)}" for name, value in values.items()
    }


def rollback(
    request: Request,
    table: Mapping[str, ParameterInfo],
    switches: Mapping[str, tuple[str, str]],
    values: Mapping[str, float],
) -> bytes:
    """Return the file that restores the previous settings; those in no previous file are Betaflight's defaults."""
    chosen = profile(request.settings)
    usual = {name: default for name, (_, default) in switches.items()}
    usual |= {name: f"{int(table[name].usual)}" for name in values}
    before = {} if request.previous is None else read_cli(request.previous, chosen)
    back: dict[str, str] = {}
    for name, default in usual.items():
        back[name] = before.get(name, default)
        if name in table and request.previous is not None:
            parse_integer(back[name], name, request.previous)
    missing = [name for name in usual if name not in before]
    source = "the previous settings" if before else f"the defaults of {NAME}: no previous settings were given"
    about = [*heading(request, parameter_comment)[:2], f"Rollback to {source}. {LOADING}"]
    if before and missing:
        about.append(f"At the default of {NAME}, for the previous file lacks them: {', '.join(missing)}")
    selected = 0 if request.previous is None else read_selected(request.previous)
    return write_cli(back, chosen, about, selected)


def check_level(controller: Controller, rotors: Actuation, before: Mapping[str, float]) -> None:
    """Raise InputError where roll and pitch angle loops differ beyond the resolution."""
    forms = loops(controller, rotors, before)
    roll, pitch = (forms[axis].outer for axis in ("roll", "pitch"))
    if nearest(LEVEL * roll) != nearest(LEVEL * pitch):
        raise InputError(
            f"the angle loop of pitch is {pitch:.3g} 1/s and that of roll {roll:.3g} 1/s; {NAME} has one angle_p_gain, in "
            'steps of 0.1 1/s: tune them together, as "tilt.kp", "tilt.ki" and "tilt.kd" in the study\'s [gains]',
            key="pitch.kp",
        )


def check_rounding(written: tuple[HeldParameter, ...]) -> None:
    """Refuse gains that round to nothing: a loop without damping or without integral is another law."""
    for parameter in written:
        if parameter.held == 0.0 and parameter.unrounded > 0.0:
            factor = 1.0 / parameter.unrounded
            raise InputError(
                f"works out at {parameter.unrounded:.3g} and rounds to 0; {NAME} holds whole numbers: raise "
                f"{native_loops.NATIVE_TABLE[parameter.name].source} about {factor:.2g} times, or take a target with finer gains",
                key=parameter.name,
            )


def held_controller(
    requested: Controller, values: Mapping[str, float], rotors: Actuation, before: Mapping[str, float]
) -> Controller:
    """Return the controller that flies with rounded settings; heading loop, position loops and filters stay as asked."""
    filters = {axis: pid.axis_gains(requested, axis).t_f for axis in ATTITUDE_AXES}
    heading_loop = loops(requested, rotors, before)["yaw"].outer
    gains = from_betaflight(values, requested.airframe.vehicle, rotors, filters, heading_loop)
    tilt = tilt_limit(values) if ANGLE_LIMIT in values else requested.options.tilt_limit
    return replace(pid.with_gains(requested, gains), options=replace(requested.options, tilt_limit=tilt))


def _differences(
    controller: Controller,
    written: tuple[HeldParameter, ...],
    rotors: Actuation,
    before: Mapping[str, float],
    unchanged: tuple[str, ...],
    request: Request,
) -> tuple[str, ...]:
    cascade = loops(controller, rotors, before)
    weights = {axis: cascade[axis].setpoint_weight for axis in ("roll", "pitch")}
    rounded = ", ".join(
        f"{one.name} {one.unrounded:.4g} -> {one.held:.0f} ({100.0 * (one.held / one.unrounded - 1.0):+.1f} %)"
        for one in written
        if one.name[:2] in ("p_", "i_") and one.unrounded > 0.0
    )
    level = next(one for one in written if one.name == "angle_p_gain")
    return (
        *pid.rate_sources(request.controller),
        "The position loops are not carried: in Betaflight the pilot, or a computer that takes the pilot's place, gives tilt and "
        "throttle; what is verified flies them as tuned.",
        f"The heading loop of yaw ({cascade['yaw'].outer:.4g} 1/s) is not carried: Betaflight controls the yaw rate, not the "
        "heading; what is verified has it.",
        f"Gains are whole numbers: {rounded}; angle_p_gain {level.unrounded:.4g} -> {level.held:.0f}, "
        "the same for roll and pitch.",
        pid.setpoint_weights(weights),
        f"Thrust does not follow the command: one unit of output is worth {command_slope(rotors, 0.0):.4g} N of each rotor "
        "for the whole motor range, the slope at hover, so loop gains grow with the throttle; the range above "
        "dshot_idle_value (default 5.5 %) counts as the whole, and battery compensation is taken as off.",
        f"Our derivative filters ({pid.rate_filters(controller, ATTITUDE_AXES)}) are not carried: the loops see the gyro through "
        "its low-pass (gyro_lpf2, default 500 Hz), notch and RPM filters, and angles through the filter of angle mode.",
        f"Every loop of ours runs each {1000.0 * controller.control_period:g} ms; Betaflight runs its loops at the gyro rate "
        "over pid_process_denom, 0.125 to 1 ms, with less delay.",
        "Anti-windup differs: Betaflight clips the integral at iterm_windup (default 80 %) of pidsum_limit (default 500 of "
        "1000, yaw 400), so at 400, yaw 320, ours back-calculates with ki/kp; outputs are limited to pidsum_limit. Neither is "
        "changed.",
        _extra(before, unchanged, request),
        "Rates are limited by the rate profile, tilt by angle_limit through the stick; ours are limited by the position "
        "loops alone.",
    )


def _extra(before: Mapping[str, float], unchanged: tuple[str, ...], request: Request) -> str:
    """Return the sentence on the terms that our law has not."""
    if request.previous is None:
        return (
            "The D terms (d, d_max), feed-forward, throttle attenuation (tpa_rate), anti-gravity, I-term relax, the yaw low-pass "
            "and the sliders are switched off, because our law has none of them; the vehicle is then as sensitive to propeller "
            "wash as our gains are. With --previous they stay as the vehicle has them."
        )
    texts = read_cli(request.previous, profile(request.settings))
    standing = {
        name: f"{before[name]:.0f}" if name in before else texts.get(name, SWITCHES[name][1]) for name in unchanged
    }
    active = ", ".join(f"{name} = {text}" for name, text in standing.items() if text not in ("0", "OFF"))
    return (
        f"Our law has no such terms, so they are not written, stay as the vehicle has them and are not in what is verified: "
        f"{active or 'none is on'}."
    )


TARGET = ExportTarget(
    name="betaflight",
    title=f"{NAME}, settings for the command line",
    export=export,
    attitude_laws=("pid", "betaflight"),
    options=OPTIONS,
    importer=IMPORTER,
)
