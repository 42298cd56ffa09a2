"""Betaflight 2025.12: our attitude PID as a file for its command line.

Rate loops PI with the level strength (angle mode) around roll and pitch, in whole numbers; heading and position have no loop that
could be carried. src/main/flight/pid.c, mixer.c.
"""

from collections.abc import Mapping
from dataclasses import replace

from plant.airframes.actuation import Actuation, actuation
from plant.cascade import ATTITUDE_AXES
from plant.errors import InputError
from tuner.export.autopilot_pid import axis_gains, rate_filters, setpoint_weights, with_gains, with_measured_rates
from tuner.export.autopilot_scales import command_slope
from tuner.export.betaflight_map import LEVEL, from_betaflight, loops, tilt_limit, to_betaflight
from tuner.export.betaflight_ranges import SWITCHES, TABLE
from tuner.export.betaflight_text import PROFILES, read_cli, whole, write_cli
from tuner.export.exporter import Bundle, Exporter, Option, Parameter, Request
from tuner.export.heading import heading
from tuner.export.parameter_table import Entry, parameters
from tuner.export.settings import number
from tuner.export.texts import parameter_comment
from tuner.gains_file import Controller

FILE = "holdfast.betaflight.txt"
NAME = "Betaflight 2025.12"

OPTIONS = (
    Option(
        "thrust_curve",
        "factor f of the rotors' thrust T = T_max (f u^2 + (1 - f) u) of the command u, 0 to 1",
        default="1",
    ),
    Option("profile", "PID profile that is written, 0 to 3", default="0"),
)


def carry(request: Request) -> Bundle:
    """Return the file; raises InputError where the gains have no form in Betaflight or leave its ranges."""
    asked = with_measured_rates(request.controller)
    rotors = actuation(asked.airframe.vehicle, number(request.settings, "thrust_curve", 0.0, 1.0, "1"))
    check_level(asked)
    written = parameters(TABLE, to_betaflight(asked, rotors), nearest, NAME)
    check_rounding(written)
    values = {parameter.name: parameter.held for parameter in written}
    about = (
        *heading(request, parameter_comment),
        f"For {NAME}. Load it on the command line: an error is a line of three hash signs, and it saves all the same.",
    )
    return Bundle(
        files={FILE: write_cli(settings(values, SWITCHES), profile(request.settings), about)},
        rollback={FILE: rollback(request, TABLE, SWITCHES, values)},
        held=held_controller(asked, values, rotors),
        lossy=_lossy(asked, written, rotors),
        target_version=NAME,
        parameters=written,
    )


def nearest(value: float) -> float:
    """Round to a whole number."""
    return float(round(value))


def profile(options: Mapping[str, str]) -> int:
    """Return the PID profile of the options."""
    value = number(options, "profile", 0.0, PROFILES - 1.0, "1")
    if value != int(value):
        raise InputError(f"given {value:g}; this must be a whole number from 0 to {PROFILES - 1}", key="--set profile")
    return int(value)


def settings(values: Mapping[str, float], switches: Mapping[str, tuple[str, str]]) -> dict[str, str]:
    """Return everything that is set, as text; switches first, for the sliders overwrite gains while they are on."""
    return {name: choice for name, (choice, _) in switches.items()} | {
        name: f"{int(value)}" for name, value in values.items()
    }


def rollback(
    request: Request, table: Mapping[str, Entry], switches: Mapping[str, tuple[str, str]], values: Mapping[str, float]
) -> bytes:
    """Return the file that brings back what stood before; what no previous file tells stands at Betaflight's default."""
    chosen = profile(request.settings)
    usual = {name: default for name, (_, default) in switches.items()}
    usual |= {name: f"{int(table[name].usual)}" for name in values}
    before = {} if request.previous is None else read_cli(request.previous, chosen)
    back: dict[str, str] = {}
    for name, default in usual.items():
        back[name] = before.get(name, default)
        if name in table and request.previous is not None:
            whole(back[name], name, request.previous)
    missing = [name for name in usual if name not in before]
    source = "the previous settings" if before else f"the defaults of {NAME}: no previous settings were given"
    about = [*heading(request, parameter_comment)[:2], f"Rollback to {source}."]
    if before and missing:
        about.append(f"At the default of {NAME}, for the previous file lacks them: {', '.join(missing)}")
    return write_cli(back, chosen, about)


def check_level(controller: Controller) -> None:
    """Refuse roll and pitch whose angle loops differ by more than the resolution of the one level strength for both."""
    roll, pitch = (loops(controller)[axis].outer for axis in ("roll", "pitch"))
    if nearest(LEVEL * roll) != nearest(LEVEL * pitch):
        raise InputError(
            f"the angle loop of pitch is {pitch:.3g} 1/s and that of roll {roll:.3g} 1/s; {NAME} has one angle_p_gain, in "
            'steps of 0.1 1/s: tune them together, as "tilt.kp", "tilt.ki" and "tilt.kd" in the study\'s [gains]',
            key="pitch.kp",
        )


def check_rounding(written: tuple[Parameter, ...]) -> None:
    """Refuse gains that round to nothing: a loop without damping or without integral is another law."""
    for parameter in written:
        if parameter.held == 0.0 and parameter.asked > 0.0:
            factor = 1.0 / parameter.asked
            raise InputError(
                f"works out at {parameter.asked:.3g} and rounds to 0; {NAME} holds whole numbers: raise "
                f"{TABLE[parameter.name].source} about {factor:.2g} times, or take a target with finer gains",
                key=parameter.name,
            )


def held_controller(asked: Controller, values: Mapping[str, float], rotors: Actuation) -> Controller:
    """Return the controller that flies with rounded settings; heading loop, position loops and filters stay as asked."""
    filters = {axis: axis_gains(asked, axis).t_f for axis in ATTITUDE_AXES}
    gains = from_betaflight(values, asked.airframe.vehicle, rotors, filters, loops(asked)["yaw"].outer)
    return replace(with_gains(asked, gains), options=replace(asked.options, tilt_limit=tilt_limit(values)))


def _lossy(controller: Controller, written: tuple[Parameter, ...], rotors: Actuation) -> tuple[str, ...]:
    cascade = loops(controller)
    weights = {axis: cascade[axis].setpoint_weight for axis in ("roll", "pitch")}
    rounded = ", ".join(
        f"{one.name} {one.asked:.4g} -> {one.held:.0f} ({100.0 * (one.held / one.asked - 1.0):+.1f} %)"
        for one in written
        if one.name[:2] in ("p_", "i_") and one.asked > 0.0
    )
    level = next(one for one in written if one.name == "angle_p_gain")
    return (
        "The position loops are not carried: in Betaflight the pilot, or a computer that takes the pilot's place, gives tilt and "
        "throttle; what is verified flies them as tuned.",
        f"The heading loop of yaw ({cascade['yaw'].outer:.4g} 1/s) is not carried: Betaflight controls the yaw rate, not the "
        "heading; what is verified has it.",
        f"Gains are whole numbers: {rounded}; angle_p_gain {level.asked:.4g} -> {level.held:.0f}, the same for roll and pitch.",
        setpoint_weights(weights),
        f"Thrust does not follow the command: one unit of output is worth {command_slope(rotors, 0.0):.4g} N of each rotor "
        "for the whole motor range, the slope at hover, so loop gains grow with the throttle; the range above "
        "dshot_idle_value (default 5.5 %) counts as the whole, and battery compensation is taken as off.",
        f"Our derivative filters ({rate_filters(controller, ATTITUDE_AXES)}) are not carried: the loops see the gyro through its "
        "low-pass (gyro_lpf2, default 500 Hz), notch and RPM filters, and angles through the filter of angle mode.",
        f"Every loop of ours runs each {1000.0 * controller.control_period:g} ms; Betaflight runs its loops at the gyro rate "
        "over pid_process_denom, 0.125 to 1 ms, with less delay.",
        "Anti-windup differs: Betaflight slows the integral from iterm_windup (default 85 %) of the motor range on and clips "
        "it at iterm_limit = 500 of 1000, ours back-calculates with ki/kp; outputs are limited to pidsum_limit (default 500, "
        "yaw 400).",
        "The D terms (d, d_max), feed-forward, throttle attenuation (tpa_rate), anti-gravity, I-term relax, the yaw low-pass "
        "and the sliders are switched off, for our law has none of them; the vehicle is then as sensitive to propeller wash "
        "as our gains are.",
        "Rates are limited by the rate profile, tilt by angle_limit through the stick; ours are limited by the position "
        "loops alone.",
    )  # fmt: skip


EXPORTER = Exporter(
    name="betaflight",
    title=f"{NAME}, settings for the command line",
    carry=carry,
    attitude_laws=("pid",),
    options=OPTIONS,
)
