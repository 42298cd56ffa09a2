"""Crazyflie: parameters of the firmware's own cascade where both laws are PID, an out-of-tree controller for every law.

The controller stands around the C99 code: bitcraze/crazyflie-firmware, docs/development/oot.md and
src/modules/interface/stabilizer_types.h. The firmware gives position [m], velocity [m/s] and the attitude quaternion in our
frames, gyro rates in deg/s about our axes, and setpoints of attitude in degrees with pitch positive nose up, the opposite of
ours. Torques are written so that the firmware's mixing, with its own arm and its own torque per thrust, ends at the very rotor
thrusts that the controller decided, whatever the airframe's arm and propellers are: at 0.0397 m instead of the firmware's
0.046 m, torques as they are would come out 14 % small.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import degrees, radians

from plant.airframes.actuation import actuation
from plant.airframes.scales import motors_text
from plant.errors import InputError
from tuner.exchange.aboard import Aboard, aboard, rollback_request, said_of_others
from tuner.exchange.autopilot.parameters import defaults, single
from tuner.exchange.autopilot.pid import (
    axis_gains,
    rate_filters,
    rate_loop,
    rate_sources,
    setpoint_weights,
    with_measured_rates,
)
from tuner.exchange.c99.sources import c_sources
from tuner.exchange.crazyflie import text as param_file
from tuner.exchange.crazyflie.import_ import FULL_THRUST, IMPORTER, full_thrust
from tuner.exchange.crazyflie.map import (
    ATTITUDE,
    ENTRIES,
    HORIZONTAL,
    MOTORS,
    TABLE,
    check_mixing,
    held,
    parameters,
    rounded,
    units,
)
from tuner.exchange.crazyflie.own_loops import CARRIED, is_own, own_held, own_values
from tuner.exchange.target import Bundle, ExportTarget, HeldParameter, Option, Request
from tuner.exchange.texts import c_comment, filled, heading, markdown, parameter_comment
from tuner.gains import Controller

FIRMWARE = "crazyflie-firmware 2025 and later, platform cf2"
FILE = "holdfast_params.yaml"
CONTROLLER_FILES = (
    "Kbuild", "Makefile", "README.md", "app-config", "src/Kbuild", "src/app_main.c", "src/controller_holdfast.c",
    "src/controller_holdfast.h",
)  # fmt: skip
# Period of the firmware's stabilizer loop [s].
TICK = 0.001
BY_LAW, PARAMETERS, CONTROLLER = "by-law", "parameters", "controller"
FORM = Option(
    "form",
    "parameters of the firmware's PID, or a controller to build in; by-law: parameters where position is pid and attitude is pid "
    "or crazyflie",
    (BY_LAW, PARAMETERS, CONTROLLER),
    BY_LAW,
)
# The firmware's limit on the integral of a rate error [deg]; it is no parameter.
INTEGRAL = {"roll": 33.3, "pitch": 33.3, "yaw": 166.7}


def export(request: Request) -> Bundle:
    """Write parameters or a controller, as the option `form` says; see `ExportTarget.export`."""
    controller, form = request.controller, request.settings[FORM.name]
    position, attitude = controller.cascade.position.name, controller.cascade.attitude.name
    held_as_parameters = position == "pid" and (attitude == "pid" or is_own(controller))
    if form == PARAMETERS and not held_as_parameters:
        others = ", ".join(sorted({position, attitude} - {"pid"}))
        message = f"given '{form}', but the laws are {others}; the firmware's own loops are pid: leave the option out"
        raise InputError(message, key="--set form")
    if form == CONTROLLER or not held_as_parameters:
        return as_controller(request)
    return as_own_parameters(request) if is_own(controller) else as_parameters(request)


def as_parameters(request: Request) -> Bundle:
    """Write a parameter file for cflib."""
    controller = request.controller
    full = full_thrust(controller.airframe.vehicle, request.settings)
    written = parameters(controller, full)
    values = {parameter.name: parameter.held for parameter in written}
    keeps = held(controller, full, values)
    return Bundle(
        files={FILE: param_file.text(about(request, full), values)},
        rollback={FILE: rollback(request)},
        held=keeps,
        differences=parameter_differences(controller, keeps, full),
        target_version=FIRMWARE,
        parameters=written,
    )


def about(request: Request, full: float) -> tuple[str, ...]:
    """Return the comments of a parameter file."""
    rotors = actuation(request.controller.airframe.vehicle)
    return (
        *heading(request, parameter_comment),
        f"65535 counts are {full:.6g} N of one motor; angles in degrees",
        f"Expected of the vehicle: {motors_text(rotors, MOTORS)}",
    )


def as_own_parameters(request: Request) -> Bundle:
    """Write a parameter file for cflib with the firmware's own attitude loops."""
    asked, present = with_measured_rates(request.controller), aboard(request, TARGET.name, param_file.read)
    full, before = full_thrust(asked.airframe.vehicle, request.settings), {} if present is None else present.values
    written = rounded(own_values(asked, full, present), before)
    values = {parameter.name: parameter.held for parameter in written}
    complete = {**defaults(TABLE), **before, **values}
    keeps = own_held(asked, units(asked, full), complete, dict.fromkeys((*HORIZONTAL, "z"), 0.0))
    return Bundle(
        files={FILE: param_file.text(about(request, full), values)},
        rollback={FILE: own_rollback(request, written, present)},
        held=keeps,
        differences=own_differences(asked, keeps, full, present),
        target_version=FIRMWARE,
        parameters=written,
    )


def own_rollback(request: Request, written: tuple[HeldParameter, ...], present: Aboard | None) -> bytes:
    """Return the file that restores the parameters written: what is on the vehicle, or the firmware's defaults."""
    before: Mapping[str, float] = {} if present is None else present.values
    usual = {parameter.name: before.get(parameter.name, TABLE[parameter.name].usual) for parameter in written}
    origin = "the firmware's defaults" if present is None else f"{present.origin}, else the firmware's defaults"
    return param_file.text((*heading(request, parameter_comment), f"Rollback: {origin}"), usual)


def own_differences(asked: Controller, keeps: Controller, full: float, present: Aboard | None) -> tuple[str, ...]:
    """Return what the firmware's loops add or lack beside the gains."""
    axes = (*HORIZONTAL, "z")
    before: Mapping[str, float] = {} if present is None else present.values
    kept = {name: before[name] for name in TABLE if name in before and name not in CARRIED}
    return (
        setpoint_weights({axis: rate_loop(axis_gains(asked, axis), axis).setpoint_weight for axis in axes}),
        f"Our rate filters of the position loops are absent ({rate_filters(asked, axes)}).",
        "The gyro's filter of 80 Hz runs in the firmware at 1 kHz, ours with the loops; outputs are whole counts.",
        "A low-pass on D (pid_rate.rateFiltEn) is read when the firmware starts: restart it after the file is stored.",
        *_of_every_form(full, degrees(keeps.options.tilt_limit)),
        *said_of_others(present, kept, {}),
        *rate_sources(asked),
    )


def rollback(request: Request) -> bytes:
    """Return the file that restores the parameters written: their stored values before, or the firmware's defaults."""
    before: Mapping[str, float] = {} if request.previous is None else param_file.read(request.previous)
    known = defaults(ENTRIES)
    origin = (
        "the firmware's defaults"
        if request.previous is None
        else "what was stored before, else the firmware's defaults"
    )
    comments = (*heading(request, parameter_comment), f"Rollback: {origin}")
    return param_file.text(comments, {name: before.get(name, usual) for name, usual in known.items()})


def parameter_differences(controller: Controller, keeps: Controller, full: float) -> tuple[str, ...]:
    """Return what the firmware's cascade adds or lacks beside the gains."""
    axes = (*HORIZONTAL, "z", *ATTITUDE)
    loops = {axis: rate_loop(axis_gains(controller, axis), axis) for axis in axes}
    inertia = dict(zip(ATTITUDE, controller.airframe.vehicle.inertia, strict=True))
    limits = ", ".join(f"{axis} {inertia[axis] * loops[axis].i * radians(INTEGRAL[axis]):.3g} N m" for axis in ATTITUDE)
    rate, tilt = 1.0 / controller.control_period, degrees(keeps.options.tilt_limit)
    return (
        setpoint_weights({axis: loop.setpoint_weight for axis, loop in loops.items()}),
        f"Our rate filters are absent ({rate_filters(controller, axes)}). Rates pass the firmware's gyro filter of "
        "80 Hz, so the held gains have a filter of 2.8 ms on attitude and none on position.",
        f"The firmware runs attitude and rate at 500 Hz and position at 100 Hz, ours all at {rate:g} Hz; its integrals act in "
        "the period they are formed in, ours one period later.",
        f"Integrals of the rate loops end at a torque of {limits}; ours end with the rotors. There is no back-calculation.",
        "Outputs are whole counts, limited to 32767 of 65535.",
        *_of_every_form(full, tilt),
        *rate_sources(controller),
    )


def _of_every_form(full: float, tilt: float) -> tuple[str, ...]:
    return (
        f"65535 counts are taken as {full:.6g} N of one motor; thrust is proportional to counts only with its battery "
        "compensation.",
        "The position loops ask for at most 1.1 m/s (posCtlPid.xVelMax and others are not written).",
        f"Tilt is a/g, limited axis by axis to {tilt:.4g} deg; ours is atan(a/g), in a cone. Lift is not raised with tilt.",
        "Velocity and acceleration of the reference are not fed forward.",
    )


def as_controller(request: Request) -> Bundle:
    """Write an out-of-tree controller around the C99 code."""
    controller = request.controller
    refuse_period(controller)
    rotors = actuation(controller.airframe.vehicle)
    check_mixing(rotors)
    earlier, sentence = rollback_request(request)
    return Bundle(
        files=with_code(request),
        rollback=with_code(earlier, sentence),
        held=replace(controller, gains=tuple(map(single, controller.gains))),
        differences=(
            "All numbers are float32.",
            "A measurement that is not finite holds the last command for 50 ms; then the firmware's own PID keeps the vehicle "
            "level and sinking, or the motors stop where gyro or attitude is not finite, until mode z is disabled.",
            "The firmware's own filters act on the measurements: a gyro filter of 80 Hz, the estimator on position and velocity.",
            f"Motors end at the firmware's THRUST_MAX (0.1125 N on a 2.1), ours at {rotors.thrust_max:.4g} N; above it the "
            "firmware lowers all four alike.",
        ),
        target_version=FIRMWARE,
    )


def with_code(request: Request, sentence: str = "") -> dict[str, bytes]:
    """Return name -> content of the firmware's out-of-tree folder."""
    controller = request.controller
    code = c_sources(controller, real="float", prefix="holdfast", digest=request.digest)
    rotors = actuation(controller.airframe.vehicle)
    told = [text for text in (*heading(request, str), sentence) if text]
    words = {
        "heading": "\n".join(f" * {c_comment(text)}" for text in told),
        "introduction": "  \n".join(map(markdown, told)),
        "ticks": round(controller.control_period / TICK), "period": f"{controller.control_period:.9g}",
        "rotor_max": f"{rotors.thrust_max:#.9g}", "rotor_hover": f"{rotors.hover_thrust:#.9g}",
        "thrust": f"{rotors.thrust_max:.4g}", "motors": motors_text(rotors, MOTORS),
    }  # fmt: skip
    texts = {name: filled("crazyflie", name, **words) for name in CONTROLLER_FILES}
    texts |= {"src/holdfast_controller.c": code.source, "src/holdfast_controller.h": code.header}
    return {name: text.encode("ascii", "backslashreplace") for name, text in texts.items()}


def refuse_period(controller: Controller) -> None:
    """Refuse a control period that is no whole number of the stabilizer's ticks; raises InputError."""
    ticks = controller.control_period / TICK
    if ticks < 0.5 or abs(ticks - round(ticks)) > 1e-6:
        message = (
            f"given {1000.0 * controller.control_period:.6g} ms; the firmware's stabilizer runs every 1 ms: tune with a whole "
            "number of milliseconds"
        )
        raise InputError(message, key="controller.control_period")


TARGET = ExportTarget(
    name="crazyflie",
    title="Crazyflie, parameters for cflib (PID, or its own loops) or an out-of-tree controller (any law)",
    export=export,
    options=(FORM, FULL_THRUST),
    importer=IMPORTER,
)
