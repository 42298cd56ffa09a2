"""Crazyflie: parameters of the firmware's own cascade where both laws are PID, an out-of-tree controller for every law.

The controller stands around the C99 code: bitcraze/crazyflie-firmware, docs/development/oot.md and
src/modules/interface/stabilizer_types.h. The firmware gives position [m], velocity [m/s] and the attitude quaternion in our
frames, gyro rates in deg/s about our axes, and setpoints of attitude in degrees with pitch positive nose up, the opposite of
ours. Torques are scaled so that the firmware's mixing, with its arm (0.046 m) and torque per thrust, gives the controller's rotor
thrusts on any airframe: at 0.0397 m, unscaled torques would be 14 % small.
"""

from collections.abc import Iterable
from dataclasses import replace
from math import degrees, radians

from plant.errors import InputError
from plant.quadrotor.airframes.actuation import actuation
from tuner.exchange.aboard import VehicleParameters, describe_unmanaged, rollback_request, vehicle_parameters
from tuner.exchange.c99.quadrotor import c_sources
from tuner.exchange.target import Bundle, ExportTarget, Option, Request
from tuner.exchange.texts import c_comment, filled, heading, markdown, parameter_comment
from tuner.extensions.autopilots import pid
from tuner.extensions.autopilots.parameters import NOTHING, Values, defaults, single
from tuner.extensions.autopilots.scales import motors_text
from tuner.extensions.crazyflie import text as param_file
from tuner.extensions.crazyflie.import_ import FULL_THRUST, IMPORTER, full_thrust
from tuner.extensions.crazyflie.map import (
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
from tuner.extensions.crazyflie.native_loops import CARRIED, NATIVE_LAW, native_held, native_values
from tuner.gains import Controller

FIRMWARE = "crazyflie-firmware 2025 and later, platform cf2"
FILE = "gainproof_params.yaml"
CONTROLLER_FILES = (
    "Kbuild",
    "Makefile",
    "README.md",
    "app-config",
    "src/Kbuild",
    "src/app_main.c",
    "src/controller_gainproof.c",
    "src/controller_gainproof.h",
)
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
    held_as_parameters = position == "pid" and (attitude == "pid" or NATIVE_LAW.flies_attitude(controller))
    if form == PARAMETERS and not held_as_parameters:
        others = ", ".join(sorted({position, attitude} - {"pid"}))
        message = f"given '{form}', but the laws are {others}; the firmware's own loops are pid: leave the option out"
        raise InputError(message, key="--set form")
    if form == CONTROLLER or not held_as_parameters:
        return as_controller(request)
    return as_native_parameters(request) if NATIVE_LAW.flies_attitude(controller) else as_parameters(request)


def as_parameters(request: Request) -> Bundle:
    """Write a parameter file for cflib."""
    controller = request.controller
    full = full_thrust(controller.airframe.vehicle, request.settings)
    written = parameters(controller, full)
    values = {parameter.name: parameter.held for parameter in written}
    keeps, previous = held(controller, full, values), request.previous
    before, origin = (NOTHING, "") if previous is None else (param_file.read(previous), "what was stored before")
    return Bundle(
        files={FILE: param_file.text(about(request, full), values)},
        rollback={FILE: rollback(request, ENTRIES, before, origin)},
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


def as_native_parameters(request: Request) -> Bundle:
    """Write a parameter file for cflib with the firmware's own attitude loops."""
    requested, present = (
        pid.with_measured_rates(request.controller),
        vehicle_parameters(request, TARGET.name, param_file.read),
    )
    full, before = full_thrust(requested.airframe.vehicle, request.settings), {} if present is None else present.values
    written = rounded(native_values(requested, full, present), before)
    values = {parameter.name: parameter.held for parameter in written}
    complete = {**defaults(TABLE), **before, **values}
    keeps = native_held(requested, units(requested, full), complete, dict.fromkeys((*HORIZONTAL, "z"), 0.0))
    return Bundle(
        files={FILE: param_file.text(about(request, full), values)},
        rollback={FILE: rollback(request, values, before, "" if present is None else present.origin)},
        held=keeps,
        differences=native_differences(requested, keeps, full, present),
        target_version=FIRMWARE,
        parameters=written,
    )


def native_differences(
    requested: Controller, keeps: Controller, full: float, present: VehicleParameters | None
) -> tuple[str, ...]:
    """Return sentences on the differences between the firmware's loops and ours."""
    axes = (*HORIZONTAL, "z")
    before: Values = {} if present is None else present.values
    unchanged = {name: before[name] for name in TABLE if name in before and name not in CARRIED}
    return (
        pid.setpoint_weights(
            {axis: pid.rate_loop(pid.axis_gains(requested, axis), axis).setpoint_weight for axis in axes}
        ),
        f"Our rate filters of the position loops are absent ({pid.rate_filters(requested, axes)}).",
        "The gyro's filter of 80 Hz runs in the firmware at 1 kHz, ours with the loops; outputs are whole counts.",
        "A low-pass on D (pid_rate.rateFiltEn) is read when the firmware starts: restart it after the file is stored.",
        *_of_every_form(full, degrees(keeps.options.tilt_limit)),
        *describe_unmanaged(present, unchanged, {}),
        *pid.rate_sources(requested),
    )


def rollback(request: Request, names: Iterable[str], before: Values, origin: str) -> bytes:
    """Return the file that restores parameters; origin: of the values before, empty where there are none."""
    source = f"{origin}, else the firmware's defaults" if origin else "the firmware's defaults"
    values = {name: before.get(name, TABLE[name].usual) for name in names}
    return param_file.text((*heading(request, parameter_comment), f"Rollback: {source}"), values)


def parameter_differences(controller: Controller, keeps: Controller, full: float) -> tuple[str, ...]:
    """Return sentences on the differences between the firmware's cascade and ours."""
    axes = (*HORIZONTAL, "z", *ATTITUDE)
    loops = {axis: pid.rate_loop(pid.axis_gains(controller, axis), axis) for axis in axes}
    inertia = dict(zip(ATTITUDE, controller.airframe.vehicle.inertia, strict=True))
    limits = ", ".join(f"{axis} {inertia[axis] * loops[axis].i * radians(INTEGRAL[axis]):.3g} N m" for axis in ATTITUDE)
    rate, tilt = 1.0 / controller.control_period, degrees(keeps.options.tilt_limit)
    return (
        pid.setpoint_weights({axis: loop.setpoint_weight for axis, loop in loops.items()}),
        f"Our rate filters are absent ({pid.rate_filters(controller, axes)}). Rates pass the firmware's gyro filter of "
        "80 Hz, so the held gains have a filter of 2.8 ms on attitude and none on position.",
        f"The firmware runs attitude and rate at 500 Hz and position at 100 Hz, ours all at {rate:g} Hz; its integrals act in "
        "the period they are formed in, ours one period later.",
        f"Integrals of the rate loops end at a torque of {limits}; ours end with the rotors. There is no back-calculation.",
        "Outputs are whole counts, limited to 32767 of 65535.",
        *_of_every_form(full, tilt),
        *pid.rate_sources(controller),
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
    code = c_sources(controller, real="float", prefix="gainproof", digest=request.digest)
    rotors = actuation(controller.airframe.vehicle)
    lines = [text for text in (*heading(request, str), sentence) if text]
    words = {
        "heading": "\n".join(f" * {c_comment(text)}" for text in lines),
        "introduction": "  \n".join(map(markdown, lines)),
        "ticks": round(controller.control_period / TICK),
        "period": f"{controller.control_period:.9g}",
        "rotor_max": f"{rotors.thrust_max:#.9g}",
        "rotor_hover": f"{rotors.hover_thrust:#.9g}",
        "thrust": f"{rotors.thrust_max:.4g}",
        "motors": motors_text(rotors, MOTORS),
    }
    texts = {name: filled("tuner.extensions.crazyflie", name, **words) for name in CONTROLLER_FILES}
    texts |= {"src/gainproof_controller.c": code.source, "src/gainproof_controller.h": code.header}
    return {name: text.encode("ascii", "backslashreplace") for name, text in texts.items()}


def refuse_period(controller: Controller) -> None:
    """Raise InputError for a control period off the stabilizer's ticks."""
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
