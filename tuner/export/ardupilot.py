"""ArduPilot Copter 4.6 and 4.7: our PID as a parameter file `.param`.

Angle loop P around rate loop PI, horizontal position P around velocity PI, vertical position P around velocity P around
acceleration PI (`ardupilot_map`). Rate gains are normalised by ArduPilot's fixed motor factors of +-0.5. Every parameter that
acts in these loops is written, also where it only switches something off. libraries/AC_PID/AC_PID.cpp,
AC_AttitudeControl/AC_PosControl.cpp, AP_Motors/AP_MotorsMatrix.cpp.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from plant.airframes.actuation import Actuation, actuation
from tuner.export.ardupilot_map import (
    HORIZONTAL_LIMIT,
    ardupilot_scales,
    from_ardupilot,
    held_vertical,
    loops,
    tilt_limit,
    to_ardupilot,
)
from tuner.export.ardupilot_ranges import DIALECTS, FIRMWARES, Dialect, check_names
from tuner.export.ardupilot_text import SEPARATORS, read_param, write_param
from tuner.export.autopilot_pid import (
    axis_gains,
    check_horizontal,
    rate_filters,
    rate_sources,
    setpoint_weights,
    with_gains,
    with_measured_rates,
)
from tuner.export.exporter import Bundle, Exporter, Option, Request
from tuner.export.heading import heading
from tuner.export.parameter_table import defaults, parameters
from tuner.export.parameter_text import single
from tuner.export.settings import number
from tuner.export.texts import parameter_comment
from tuner.gains_file import Controller

FILE = "holdfast.param"

OPTIONS = (
    Option("firmware", "version of ArduPilot Copter on the vehicle: names and units differ", FIRMWARES),
    Option(
        "separator", "between name and value: comma (Mission Planner) or blank (MAVProxy)", tuple(SEPARATORS), "comma"
    ),
    Option(
        "thrust_curve",
        "factor f of the rotors' thrust T = T_max (f u^2 + (1 - f) u) of the command u, 0 to 1",
        default="1",
    ),
    Option(
        "accel_gain",
        "P gain on the measured vertical acceleration, as a share of the hover throttle per 10 m/s2, 0.2 to 5",
        default="1",
    ),
)


def carry(request: Request) -> Bundle:
    """Return the parameter file; raises InputError where the gains have no form in ArduPilot or leave its documented ranges."""
    asked = with_measured_rates(request.controller)
    dialect = DIALECTS[request.settings["firmware"]]
    target = f"ArduPilot Copter {dialect.firmware}"
    check_horizontal(asked, target)
    curve = number(request.settings, "thrust_curve", 0.0, 1.0, "1")
    accel_gain = number(request.settings, "accel_gain", 0.2, 5.0, "1")
    rotors = actuation(asked.airframe.vehicle, curve)
    written = parameters(dialect.table, to_ardupilot(asked, rotors, curve, dialect, accel_gain), single, target)
    values = {parameter.name: parameter.held for parameter in written}
    about = (
        *heading(request, parameter_comment),
        f"For {target} and no other version: a vehicle ignores names that it does not know.",
        _frame(rotors),
    )
    return Bundle(
        files={FILE: write_param(values, request.settings["separator"], about)},
        rollback={FILE: _rollback(request, values, dialect, target)},
        held=held_controller(asked, values, rotors, dialect),
        lossy=_lossy(request.controller, values, rotors, dialect),
        target_version=target,
        parameters=written,
    )


def held_controller(asked: Controller, values: Mapping[str, float], rotors: Actuation, dialect: Dialect) -> Controller:
    """Return the controller that ArduPilot flies with rounded parameters; our derivative filters stay as asked."""
    filters = {axis: axis_gains(asked, axis).t_f for axis in ("x", "y", "z", "roll", "pitch", "yaw")}
    gains = from_ardupilot(values, asked.airframe.vehicle, rotors, dialect, filters)
    return replace(with_gains(asked, gains), options=replace(asked.options, tilt_limit=tilt_limit(values)))


def _rollback(request: Request, values: Mapping[str, float], dialect: Dialect, target: str) -> bytes:
    """Return the file that brings back what stood before; what no previous file tells stands at the default."""
    before = {} if request.previous is None else _previous(request.previous, dialect)
    usual = defaults(dialect.table)
    missing = [name for name in values if name not in before]
    source = (
        "the previous parameter file" if before else f"the defaults of {target}: no previous parameter file was given"
    )
    about = [*heading(request, parameter_comment)[:2], f"Rollback to {source}."]
    if before and missing:
        about.append(f"At the default of {target}, for the previous file lacks them: {', '.join(missing)}")
    back = {name: before.get(name, usual[name]) for name in values}
    return write_param(back, request.settings["separator"], about)


def _previous(file: Path, dialect: Dialect) -> dict[str, float]:
    values = read_param(file)
    check_names(values, dialect, file)
    return values


def _frame(rotors: Actuation) -> str:
    """Return the frame that the vehicle must be set up with, as a comment."""
    first = rotors.rotors[0]
    kind = "X" if abs(first.y) > 1e-6 * abs(first.x) else "plus"
    return (
        f"The vehicle must be a quad (FRAME_CLASS 1) of frame {kind} with front rotor 1 turning {_turns(first.spin)}."
    )


def _turns(spin: float) -> str:
    return "clockwise seen from above" if spin > 0.0 else "counter-clockwise seen from above"


def _lossy(controller: Controller, values: Mapping[str, float], rotors: Actuation, dialect: Dialect) -> tuple[str, ...]:
    scales = ardupilot_scales(controller.airframe.vehicle, rotors, values["MOT_THST_EXPO"])
    accel = held_vertical(values, scales, dialect).accel
    weights = {axis: loop.setpoint_weight for axis, loop in loops(controller).items()}
    position = "PSC_ACCZ_FLTE" if dialect.firmware == "4.6" else "PSC_D_ACC_FLTE"
    return (
        *rate_sources(controller),
        setpoint_weights(weights),
        f"The vertical loop has a PI on the measured acceleration that ours lacks: with K = {accel:.3g} it acts as "
        f"{1.0 + accel:.3g} times the mass, with the poles of our PID but other margins and less disturbance; the measured "
        f"acceleration passes {position} (default 20 Hz), which is not changed.",
        f"Our derivative filters ({rate_filters(controller, ('roll', 'pitch', 'yaw', 'x', 'z'))}) are not "
        "carried: the rate loops see the gyro through INS_GYRO_FILTER (default 20 Hz) and the notch filters, the "
        "velocity loops what the estimator gives.",
        "The rate target, which holds the measured angle, is low-passed by ATC_RAT_*_FLTT, set to 100 Hz for roll and "
        "pitch and 50 Hz for yaw, the highest documented; ours is not. ATC_RAT_YAW_FLTE (default 2.5 Hz), "
        f"{dialect.names['vxy_flte']} and {dialect.names['vz_flte']} (default 5 Hz) are switched off.",
        f"Every loop of ours runs each {1000.0 * controller.control_period:g} ms; ArduPilot runs them at SCHED_LOOP_RATE "
        "(default 400 Hz, 2.5 ms), with the delays of its estimator.",
        "Angle and position errors pass square-root controllers (limits of angular acceleration, PSC_JERK_*): equal to ours for "
        "small errors only.",
        "Anti-windup differs: ArduPilot lets an integral only shrink while its output is limited and clips it at "
        f"IMAX (1, the whole normalised torque; {HORIZONTAL_LIMIT:g} m/s2 for the horizontal velocity), ours "
        "back-calculates with ki/kp.",
        "The D, FF, D_FF and SMAX terms are 0: ArduPilot's derivative of the filtered rate error and its slew limiter have "
        "no counterpart in our law.",
        f"Thrust is linearised by MOT_THST_EXPO = {values['MOT_THST_EXPO']:.4g} between MOT_SPIN_MIN and MOT_SPIN_MAX: "
        f"the largest thrust ({rotors.thrust_max:.4g} N of each rotor) is taken at MOT_SPIN_MAX, and none at MOT_SPIN_MIN.",
        "The battery's voltage scales the thrust unless MOT_BAT_VOLT_MAX and MOT_BAT_VOLT_MIN are set; ours is constant.",
    )


EXPORTER = Exporter(
    name="ardupilot",
    title="ArduPilot Copter 4.6 or 4.7, parameter file",
    carry=carry,
    position_laws=("pid",),
    attitude_laws=("pid",),
    options=OPTIONS,
)
