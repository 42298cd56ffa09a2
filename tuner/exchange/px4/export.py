"""PX4: our PID as a parameter file of QGroundControl.

Angle loop P around rate loop PI, position loop P around velocity loop PI: the form that `autopilot.pid` gives our PID, with the
same feedback. Rate gains are normalised by PX4's control allocation from the airframe's own rotors (`autopilot.scales`).
On a vehicle that is known (`aboard`) everything that our loops do not carry stays as it is; otherwise every parameter that acts
in these loops is written, also where it only switches something off. PX4 1.16:
src/lib/rate_control/rate_control.cpp, mc_att_control/AttitudeControl, mc_pos_control/PositionControl.
"""

from collections.abc import Mapping
from dataclasses import replace

from plant.airframes.actuation import Actuation, actuation
from plant.cascade import ATTITUDE_AXES, AXES
from plant.errors import InputError
from tuner.exchange.aboard import DERIVATIVE, KEEP, OTHERS, Aboard, aboard, said_of_others
from tuner.exchange.autopilot.parameters import defaults, parameters, single
from tuner.exchange.autopilot.pid import (
    axis_gains,
    check_horizontal,
    held_cutoff,
    held_tilt,
    rate_filters,
    rate_sources,
    setpoint_weights,
    with_gains,
    with_measured_rates,
)
from tuner.exchange.autopilot.scales import Motors, command_slope, motors, motors_text
from tuner.exchange.px4.import_ import IMPORTER
from tuner.exchange.px4.map import (
    CARRIED,
    HOVER,
    LIMITS,
    MODEL,
    TABLE,
    YAW_FILTER,
    completed,
    from_px4,
    px4_loops,
    switched_off,
    tilt_limit,
    to_px4,
)
from tuner.exchange.px4.text import VERSION, read_params, write_params
from tuner.exchange.target import Bundle, GyroFilter, Option, Request, Target, number
from tuner.exchange.texts import heading, parameter_comment
from tuner.gains import Controller

FILE = "holdfast.params"
NAME = f"PX4 {VERSION}"
# Low-pass of the gyro and its default [Hz].
GYRO, GYRO_CUTOFF = "IMU_GYRO_CUTOFF", 40.0
# What turns our gains into PX4's units.
SCALING = (*(f"MC_{axis.upper()}RATE_K" for axis in LIMITS), MODEL, HOVER)
# Its numbers of our rotors 1 to 4 in its geometry of a quad X; CA_ROTOR0 is motor 1.
MOTORS: Motors = (3, 1, 2, 4)

OPTIONS = (
    Option("thrust_curve", "factor f of the rotors' thrust T = T_max (f u^2 + (1 - f) u) of the command u, 0 to 1", default="1"),
    Option(
        "thrust_model",
        "vehicle: THR_MDL_FAC stays as it is on the vehicle, and is f where that is not known; linearised: it is f, thrust "
        "follows the command; local: it is 0, the slope at hover counts",
        ("vehicle", "linearised", "local"),
        "vehicle",
    ),
    OTHERS,
    DERIVATIVE,
    Option("vehicle", "MAVLink id of the vehicle that loads the file, 1 to 255", default="1"),
)  # fmt: skip


def export(request: Request) -> Bundle:
    """Return the parameter file; raises InputError where the gains have no form in PX4 or leave its documented ranges."""
    asked = with_measured_rates(request.controller, yaw_filter=True)
    check_horizontal(asked, NAME)
    curve = number(request.settings, "thrust_curve", 0.0, 1.0, "1")
    rotors = actuation(asked.airframe.vehicle, curve)
    present = aboard(request, "px4", read_params)
    before = {} if present is None else present.values
    beside = _beside(request.settings, rotors, curve, present)
    complete = completed(beside, rotors)
    counted = request.settings["rate_derivative"] == "inertia"
    carried = to_px4(asked, rotors, complete, None if present is None else present.values, counted)
    wanted = {name: {**carried, **beside}[name] for name in TABLE if name in carried or name in beside}
    kept = [name for name, value in beside.items() if before.get(name) == value]
    written = parameters(TABLE, wanted, single, NAME, before, kept)
    values = {parameter.name: parameter.held for parameter in written}
    vehicle = _vehicle(request.settings)
    about = (
        *heading(request, parameter_comment),
        f"For {NAME}; ranges and units are those of this version.",
        _geometry(rotors),
    )
    assumed = {name: complete[name] for name in SCALING if name not in beside}
    return Bundle(
        files={FILE: write_params(values, vehicle, about)},
        rollback={FILE: _rollback(request, values, vehicle, present)},
        held=held_controller(asked, {**complete, **values}, rotors, counted),
        differences=(
            *said_of_others(present, {name: beside[name] for name in kept}, assumed),
            *_differences(request.controller, rotors, curve, complete, wanted),
        ),
        target_version=NAME,
        parameters=written,
        gyro=GyroFilter(GYRO, before.get(GYRO, GYRO_CUTOFF), GYRO in before),
    )


def _beside(
    settings: Mapping[str, str], rotors: Actuation, curve: float, present: Aboard | None
) -> Mapping[str, float]:  # fmt: skip
    """Return what is written beside what our loops carry: as it is on the vehicle, or such that nothing else acts."""
    choice = settings["thrust_model"]
    off = switched_off(rotors, 0.0 if choice == "local" else curve)
    if present is None or settings[OTHERS.name] != KEEP:
        return off
    kept = {name: value for name, value in present.values.items() if name in TABLE and name not in CARRIED}
    return kept if choice == "vehicle" else kept | {name: off[name] for name in (MODEL, HOVER)}


def held_controller(asked: Controller, values: Mapping[str, float], rotors: Actuation, counted: bool) -> Controller:
    """Return the controller that PX4 flies with rounded parameters; our derivative filters stay as asked."""
    filters = {axis: axis_gains(asked, axis).t_f for axis in AXES}
    gains = from_px4(values, asked.airframe.vehicle, rotors, filters, counted)
    cutoff = held_cutoff(values[YAW_FILTER])
    options = replace(asked.options, tilt_limit=held_tilt(tilt_limit(values)), yaw_torque_cutoff=cutoff)
    return replace(with_gains(asked, gains), options=options)


def _vehicle(settings: Mapping[str, str]) -> int:
    value = number(settings, "vehicle", 1.0, 255.0, "1")
    if value != int(value):
        raise InputError(f"given {value:g}; this must be a whole number from 1 to 255", key="--set vehicle")
    return int(value)


def _rollback(request: Request, values: Mapping[str, float], vehicle: int, present: Aboard | None) -> bytes:
    """Return the file that restores the previous parameters; those that are not known are PX4's defaults."""
    before = {} if present is None else present.values
    usual = defaults(TABLE)
    missing = [name for name in values if name not in before]
    source = f"the defaults of {NAME}: no previous parameter file was given" if present is None else present.origin
    about = [*heading(request, parameter_comment)[:2], f"Rollback to {source}."]
    if present is not None and missing:
        about.append(f"At the default of {NAME}, for that file lacks them: {', '.join(missing)}")
    return write_params({name: before.get(name, usual[name]) for name in values}, vehicle, about)


def _geometry(rotors: Actuation) -> str:
    """Return what CA_ROTORi_* must describe for the torques to be right, as a comment: in body FRD, KM above 0 for CCW."""
    places = "; ".join(
        f"CA_ROTOR{number - 1} ({place}) PX {rotor.x:.4g} m, PY {0.0 - rotor.y:.4g} m, "
        f"KM {-rotor.spin * rotor.torque_ratio:.4g} m"
        for number, place, rotor in motors(rotors, MOTORS)
    )
    return (
        f"The vehicle's CA_ROTORi_* must describe these rotors, numbered as PX4's quad X is or in another order, with equal CT: "
        f"{places}; {motors_text(rotors, MOTORS)}."
    )


def _differences(
    controller: Controller, rotors: Actuation, curve: float, complete: Mapping[str, float], values: Mapping[str, float]
) -> tuple[str, ...]:
    cascade = px4_loops({**complete, **values}, controller.airframe.vehicle, rotors)
    weights = {axis: loop.setpoint_weight for axis, loop in cascade.items()}
    return (
        *rate_sources(controller, yaw_filter=True),
        setpoint_weights({axis: weights[axis] for axis in ("x", "z", *ATTITUDE_AXES)}),
        f"Our derivative filters ({rate_filters(controller, ('roll', 'pitch', 'yaw', 'x', 'z'))}) are not "
        "carried: the rate loops see the gyro through IMU_GYRO_CUTOFF (default 40 Hz, second order) and the notch filters, "
        "the velocity loops what the estimator gives.",
        f"{_thrust(rotors, curve, complete[MODEL])}; the CA_ROTORi_* on the vehicle must describe the airframe's rotors (they "
        "are in the file as a comment).",
        f"Every loop of ours runs each {1000.0 * controller.control_period:g} ms; PX4 runs the rate loop with the gyro "
        "(IMU_GYRO_RATEMAX, default 400 Hz), the attitude and position loops with their estimates, "
        "and adds their delays.",
        "PX4 multiplies the integral gain of the rate loops by max(0, 1 - (e / 400 deg/s)^2) of the rate error e.",
        "Anti-windup differs: PX4 stops the integral of an axis that its allocation reports as saturated and clips it at "
        f"MC_*_INT_LIM ({', '.join(f'{axis} {complete[name]:g}' for axis, name in LIMITS.items())} of the normalised torque), "
        "ours back-calculates with ki/kp; in the position loops PX4 back-calculates with 2/P along x and y and stops along z, "
        "where it clips at 9.81 m/s2.",
        *_switched_off(values),
        "PX4's attitude error is the vector of a quaternion with sin(angle/2), its rates and speeds are limited (MC_*RATE_MAX, "
        "MPC_*_VEL_MAX, trajectories with MPC_JERK_*): equal to ours for small errors only.",
        "MPC_USE_HTE (default 1) replaces MPC_THR_HOVER by an estimate in flight, which follows the battery; our vertical gains "
        "take hover as known.",
    )  # fmt: skip


def _thrust(rotors: Actuation, curve: float, model: float) -> str:
    """Return what becomes of the rotors' curve."""
    if model == curve:
        return f"Thrust is linearised by THR_MDL_FAC = {model:g}, right if the rotors' curve has that factor"
    return (
        f"THR_MDL_FAC is {model:g} and the rotors' curve has f = {curve:g}: torques and climb are scaled with "
        f"{command_slope(rotors, model):.4g} N per unit command, the slope at hover, and change with the throttle"
    )


def _switched_off(values: Mapping[str, float]) -> tuple[str, ...]:
    """Return sentences on what is written only to switch something off."""
    sentences = []
    if values.get("MC_ROLLRATE_D") == values.get("MPC_XY_VEL_D_ACC") == 0.0:
        sentences.append(
            "MC_*RATE_D, MC_*RATE_FF and MPC_*_VEL_D_ACC are 0: PX4's terms on measured acceleration have no counterpart in our "
            "law (MPC_XY_VEL_D_ACC = 0 is below the documented 0.1)."
        )
    if values[YAW_FILTER] == 0.0:
        sentences.append("MC_YAW_TQ_CUTOFF is 0, for our yaw torque is not low-passed (default 2 Hz).")
    return tuple(sentences)


TARGET = Target(
    name="px4",
    title=f"{NAME}, parameter file of QGroundControl",
    export=export,
    position_laws=("pid",),
    attitude_laws=("pid",),
    options=OPTIONS,
    importer=IMPORTER,
)
