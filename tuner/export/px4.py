"""PX4: our PID as a parameter file of QGroundControl.

Angle loop P around rate loop PI, position loop P around velocity loop PI: the form that `pid_cascade` gives our PID, with the
same feedback. Rate gains are normalised by PX4's control allocation from the airframe's own rotors (`autopilot_scales`).
Every parameter that acts in these loops is written, also where it only switches something off. PX4 1.16:
src/lib/rate_control/rate_control.cpp, mc_att_control/AttitudeControl, mc_pos_control/PositionControl.
"""

from collections.abc import Mapping
from dataclasses import replace

from plant.airframes.actuation import Actuation, actuation
from plant.errors import InputError
from tuner.export.autopilot_pid import (
    axis_gains,
    check_horizontal,
    rate_filters,
    rate_sources,
    setpoint_weights,
    with_gains,
    with_measured_rates,
)
from tuner.export.autopilot_scales import command_slope
from tuner.export.exporter import Bundle, Exporter, Option, Request
from tuner.export.heading import heading
from tuner.export.parameter_table import defaults, parameters
from tuner.export.parameter_text import single
from tuner.export.px4_map import from_px4, loops, tilt_limit, to_px4
from tuner.export.px4_ranges import TABLE
from tuner.export.px4_text import VERSION, read_params, write_params
from tuner.export.settings import number
from tuner.export.texts import parameter_comment
from tuner.gains_file import Controller

FILE = "holdfast.params"
NAME = f"PX4 {VERSION}"

OPTIONS = (
    Option("thrust_curve", "factor f of the rotors' thrust T = T_max (f u^2 + (1 - f) u) of the command u, 0 to 1", default="1"),
    Option(
        "thrust_model",
        "linearised: THR_MDL_FAC is f, thrust follows the command; local: THR_MDL_FAC is 0, the slope at hover counts",
        ("linearised", "local"),
        "linearised",
    ),
    Option("vehicle", "MAVLink id of the vehicle that loads the file, 1 to 255", default="1"),
)  # fmt: skip


def carry(request: Request) -> Bundle:
    """Return the parameter file; raises InputError where the gains have no form in PX4 or leave its documented ranges."""
    asked = with_measured_rates(request.controller)
    check_horizontal(asked, NAME)
    curve = number(request.settings, "thrust_curve", 0.0, 1.0, "1")
    model = curve if request.settings["thrust_model"] == "linearised" else 0.0
    rotors = actuation(asked.airframe.vehicle, curve)
    written = parameters(TABLE, to_px4(asked, rotors, model), single, NAME)
    values = {parameter.name: parameter.held for parameter in written}
    vehicle = _vehicle(request.settings)
    about = (
        *heading(request, parameter_comment),
        f"For {NAME}; ranges and units are those of this version.",
        _geometry(rotors),
    )
    return Bundle(
        files={FILE: write_params(values, vehicle, about)},
        rollback={FILE: _rollback(request, values, vehicle)},
        held=held_controller(asked, values, rotors),
        lossy=_lossy(request.controller, rotors, curve, model),
        target_version=NAME,
        parameters=written,
    )


def held_controller(asked: Controller, values: Mapping[str, float], rotors: Actuation) -> Controller:
    """Return the controller that PX4 flies with rounded parameters; our derivative filters stay as asked."""
    filters = {axis: axis_gains(asked, axis).t_f for axis in ("x", "y", "z", "roll", "pitch", "yaw")}
    gains = from_px4(values, asked.airframe.vehicle, rotors, filters)
    options = replace(asked.options, tilt_limit=tilt_limit(values))
    return replace(with_gains(asked, gains), options=options)


def _vehicle(settings: Mapping[str, str]) -> int:
    value = number(settings, "vehicle", 1.0, 255.0, "1")
    if value != int(value):
        raise InputError(f"given {value:g}; this must be a whole number from 1 to 255", key="--set vehicle")
    return int(value)


def _rollback(request: Request, values: Mapping[str, float], vehicle: int) -> bytes:
    """Return the file that brings back what stood before; what no previous file tells stands at PX4's default."""
    before = {} if request.previous is None else read_params(request.previous)
    usual = defaults(TABLE)
    missing = [name for name in values if name not in before]
    source = (
        "the previous parameter file" if before else f"the defaults of {NAME}: no previous parameter file was given"
    )
    about = [*heading(request, parameter_comment)[:2], f"Rollback to {source}."]
    if before and missing:
        about.append(f"At the default of {NAME}, for the previous file lacks them: {', '.join(missing)}")
    return write_params({name: before.get(name, usual[name]) for name in values}, vehicle, about)


def _geometry(rotors: Actuation) -> str:
    """Return what CA_ROTORi_* must describe for the torques to be right, as a comment: in body FRD, KM above 0 for CCW."""
    places = "; ".join(
        f"PX {rotor.x:.4g} m, PY {0.0 - rotor.y:.4g} m, KM {-rotor.spin * rotor.torque_ratio:.4g} m"
        for rotor in rotors.rotors
    )
    return f"The vehicle's CA_ROTORi_* must describe these rotors, in any order, with equal CT: {places}"


def _lossy(controller: Controller, rotors: Actuation, curve: float, model: float) -> tuple[str, ...]:
    weights = {axis: loop.setpoint_weight for axis, loop in loops(controller).items()}
    thrust = (
        f"Thrust is linearised by THR_MDL_FAC = {model:g}, right if the rotors' curve has that factor"
        if model == curve
        else f"THR_MDL_FAC is 0 and the rotors' curve has f = {curve:g}: torques and climb are scaled with "
        f"{command_slope(rotors, model):.4g} N per unit command, the slope at hover, and grow with the throttle"
    )
    return (
        *rate_sources(controller),
        setpoint_weights(weights),
        f"Our derivative filters ({rate_filters(controller, ('roll', 'pitch', 'yaw', 'x', 'z'))}) are not "
        "carried: the rate loops see the gyro through IMU_GYRO_CUTOFF (default 40 Hz, second order) and the notch filters, "
        "the velocity loops what the estimator gives.",
        f"{thrust}; the CA_ROTORi_* on the vehicle must describe the airframe's rotors (they are in the file as a comment).",
        f"Every loop of ours runs each {1000.0 * controller.control_period:g} ms; PX4 runs the rate loop with the gyro "
        "(IMU_GYRO_RATEMAX, default 400 Hz), the attitude and position loops with their estimates, "
        "and adds their delays.",
        "PX4 multiplies the integral gain of the rate loops by max(0, 1 - (e / 400 deg/s)^2) of the rate error e.",
        "Anti-windup differs: PX4 stops the integral of an axis that its allocation reports as saturated and clips it at 1 (the "
        "whole normalised torque), ours back-calculates with ki/kp; in the position loops PX4 back-calculates with 2/P along x "
        "and y and stops along z, where it clips at 9.81 m/s2.",
        "MC_*RATE_D, MC_*RATE_FF and MPC_*_VEL_D_ACC are 0: PX4's terms on measured acceleration have no counterpart in our law "
        "(MPC_XY_VEL_D_ACC = 0 is below the documented 0.1).",
        "MC_YAW_TQ_CUTOFF is 0, for our yaw torque is not low-passed (default 2 Hz); MC_YAW_WEIGHT is 1, so yaw errors count as "
        "ours do.",
        "PX4's attitude error is the vector of a quaternion with sin(angle/2), its rates and speeds are limited (MC_*RATE_MAX, "
        "MPC_*_VEL_MAX, trajectories with MPC_JERK_*): equal to ours for small errors only.",
        "MPC_USE_HTE (default 1) replaces MPC_THR_HOVER by an estimate in flight, which follows the battery; our vertical gains "
        "take hover as known.",
    )  # fmt: skip


EXPORTER = Exporter(
    name="px4",
    title=f"{NAME}, parameter file of QGroundControl",
    carry=carry,
    position_laws=("pid",),
    attitude_laws=("pid",),
    options=OPTIONS,
)
