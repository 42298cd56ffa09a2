"""ArduPilot Copter 4.6 and 4.7: our PID as a parameter file `.param`.

Angle loop P around rate loop PI, horizontal position P around velocity PI, vertical position P around velocity P around
acceleration PI (`ardupilot.map`). Rate gains are normalized by ArduPilot's fixed motor factors of +-0.5. For an unknown vehicle
every parameter of these loops is written. libraries/AC_PID/AC_PID.cpp, AC_AttitudeControl/AC_PosControl.cpp,
AP_Motors/AP_MotorsMatrix.cpp.
"""

from dataclasses import replace

from plant.errors import InputError
from plant.input_files import ReadableFile
from plant.quadrotor.airframes.actuation import Actuation, actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.exchange.aboard import DERIVATIVE, OTHERS, VehicleParameters, vehicle_parameters
from tuner.exchange.target import FIRMWARE, Bundle, ExportTarget, Option, Request
from tuner.extensions.ardupilot import ranges
from tuner.extensions.ardupilot.import_ import IMPORTER
from tuner.extensions.ardupilot.map import ArduPilot
from tuner.extensions.ardupilot.other_files import plain
from tuner.extensions.ardupilot.text import OLDER, SEPARATORS, modernized, read_param
from tuner.extensions.autopilots.assembly import CURVE, curve
from tuner.extensions.autopilots.parameters import Values
from tuner.extensions.autopilots.pid import rate_filters, rate_sources, setpoint_weights
from tuner.extensions.autopilots.scales import Motors, is_plus, motors_text
from tuner.gains import Controller

FILE = ranges.DIALECTS["4.6"].file
# Its numbers of our rotors 1 to 4 in the frames X and plus, and the frame by (plus, first rotor clockwise).
MOTORS: Motors = (3, 1, 2, 4)
FRAME_TYPES = {
    (False, True): "frame X (FRAME_TYPE 1)",
    (False, False): "frame H (FRAME_TYPE 3, the X with the other sense of rotation)",
    (True, True): "frame plus (FRAME_TYPE 0)",
    (True, False): "frame plus reversed (FRAME_TYPE 6)",
}

OPTIONS = (
    Option(FIRMWARE, "version of ArduPilot Copter on the vehicle: names and units differ", ranges.FIRMWARES),
    Option(
        ranges.SEPARATOR,
        "between name and value: comma (Mission Planner) or blank (MAVProxy)",
        tuple(SEPARATORS),
        "comma",
    ),
    CURVE,
    Option(
        ranges.ACCEL_GAIN,
        "P gain on the measured vertical acceleration, as a share of the hover throttle per 10 m/s2, 0.2 to 5; vehicle: as it is "
        "on the vehicle, and 1 where that is not known",
        default="vehicle",
    ),
    OTHERS,
    DERIVATIVE,
)


def export(request: Request) -> Bundle:
    """Return the parameter file; raises InputError where the gains have no form in ArduPilot, leave its documented ranges, or
    would keep the vehicle from arming.
    """
    vehicle, dialect = request.controller.airframe.vehicle, ranges.DIALECTS[request.settings[FIRMWARE]]
    ardupilot = ArduPilot(
        dialect.flying(request.controller.cascade), vehicle, actuation(vehicle, curve(request.settings))
    )
    present = _vehicle_parameters(request, dialect)
    about = f"For {dialect.name} and no other version: a vehicle ignores names that it does not know."
    return ardupilot.export(
        request,
        present,
        (about, _frame(ardupilot.rotors)),
        lambda values, complete: _differences(ardupilot, request.controller, {**complete, **values}, present),
    )


def _vehicle_parameters(request: Request, dialect: ranges.Dialect) -> VehicleParameters | None:
    """Return the vehicle's parameters in the dialect of the export."""
    present = vehicle_parameters(request, "ardupilot", lambda file: _previous(file, dialect))
    record = request.controller.vehicle
    if present is None or request.previous is not None or record is None:
        return present
    recorded = ranges.DIALECTS.get(record.settings.get(FIRMWARE, ""), dialect)
    return replace(present, values=ranges.translated(present.values, recorded, dialect))


def _previous(file: ReadableFile, dialect: ranges.Dialect) -> dict[str, float]:
    values = read_param(plain(file))
    ranges.check_names(values, dialect, file)
    if old := modernized(values, file).renamed:
        message = (
            f"is a name from before Copter 4.0, which ignores those of {dialect.firmware}: update the vehicle first"
        )
        raise InputError(message, file=file, key=next(iter(old)))
    return values


def _frame(rotors: Actuation) -> str:
    """Return the vehicle's required frame, as a comment."""
    kind = FRAME_TYPES[is_plus(rotors), rotors.rotors[0].spin > 0.0]
    return f"The vehicle must be a quad (FRAME_CLASS 1) of {kind}: {motors_text(rotors, MOTORS)}."


def _differences(
    ardupilot: ArduPilot, controller: Controller, values: Values, present: VehicleParameters | None
) -> tuple[str, ...]:
    dialect, thrust_max = ardupilot.version, ardupilot.rotors.thrust_max
    accel = ardupilot.vertical(values).accel
    weights = {axis: loop.setpoint_weight for axis, loop in ardupilot.loops(values).items()}
    position = "PSC_ACCZ_FLTE" if dialect.firmware == "4.6" else "PSC_D_ACC_FLTE"
    return (
        *rate_sources(controller, yaw_filter=True),
        setpoint_weights({axis: weights[axis] for axis in ("x", *ATTITUDE_AXES) if axis in weights}),
        f"The vertical loop has a PI on the measured acceleration that ours lacks: with K = {accel:.3g} it acts as "
        f"{1.0 + accel:.3g} times the mass, with the poles of our PID but other margins and less disturbance; the measured "
        f"acceleration passes {position} (default 20 Hz), which is not changed.",
        _unfiltered(controller, tuple(axis for axis in (*ATTITUDE_AXES, "x", "z") if axis in (*weights, "z"))),
        *_switched_off(values, dialect),
        f"Every loop of ours runs each {1000.0 * controller.control_period:g} ms; ArduPilot runs them at SCHED_LOOP_RATE "
        "(default 400 Hz, 2.5 ms), with the delays of its estimator.",
        "Angle and position errors pass square-root controllers (limits of angular acceleration, PSC_JERK_*): equal to ours for "
        "small errors only.",
        _integrals(dialect, values),
        f"Thrust is linearised by MOT_THST_EXPO = {values[ranges.EXPO]:.4g} between MOT_SPIN_MIN and MOT_SPIN_MAX: "
        f"the largest thrust ({thrust_max:.4g} N of each rotor) is taken at MOT_SPIN_MAX, and none at MOT_SPIN_MIN.",
        "The battery's voltage scales the thrust unless MOT_BAT_VOLT_MAX and MOT_BAT_VOLT_MIN are set; ours is constant.",
        *_older(controller, present),
    )


def _unfiltered(controller: Controller, axes: tuple[str, ...]) -> str:
    """Return the sentence on the derivative filters of our PID's axes."""
    lost = f"Our derivative filters ({rate_filters(controller, axes)}) are not carried: "
    if "roll" not in axes:
        return f"{lost}the velocity loops see what the estimator gives."
    return (
        f"{lost}the rate loops see the gyro through INS_GYRO_FILTER (default 20 Hz) and the notch filters, the "
        "velocity loops what the estimator gives."
    )


def _integrals(dialect: ranges.Dialect, values: Values) -> str:
    """Return the sentence on the differences of the integrals."""
    if "roll" not in dialect.names:
        return (
            "Anti-windup of the velocity loops differs: ArduPilot lets an integral only shrink while its output is limited, ours "
            "back-calculates with ki/kp. ArduPilot filters the gyro at its own rate, ours with the loop."
        )
    return (
        "Anti-windup differs: ArduPilot lets an integral only shrink while its output is limited and clips it at its IMAX "
        f"({values['ATC_RAT_RLL_IMAX']:g} of the normalised torque in roll; "
        f"{values[dialect.roles['vxy_imax']] / dialect.metre:g} m/s2 for the horizontal velocity), ours back-calculates with "
        "ki/kp."
    )


def _switched_off(values: Values, dialect: ranges.Dialect) -> tuple[str, ...]:
    """Return sentences on what is written only to switch something off."""
    sentences = []
    if "roll" in dialect.names and values["ATC_RAT_RLL_FLTT"] == 100.0:
        sentences.append(
            "The rate target, which holds the measured angle, is low-passed by ATC_RAT_*_FLTT, set to 100 Hz for roll and "
            "pitch and 50 Hz for yaw, the highest documented; ours is not. "
            f"{dialect.roles['vxy_flte']} and {dialect.roles['vz_flte']} (default 5 Hz) are switched off."
        )
    if "roll" in dialect.names and values["ATC_RAT_RLL_D"] == values[dialect.roles["vxy_d"]] == 0.0:
        sentences.append(
            "The D, FF, D_FF and SMAX terms are 0: ArduPilot's derivative of the filtered rate error and its slew limiter have "
            "no counterpart in our law."
        )
    return tuple(sentences)


def _older(controller: Controller, present: VehicleParameters | None) -> tuple[str, ...]:
    """Return a sentence where the vehicle's firmware was too old."""
    record = controller.vehicle
    if present is None or record is None or OLDER not in record.target_version:
        return ()
    return (
        f"The gains were imported from {record.target_version}: a vehicle that still has it ignores the names of this file "
        "until its firmware is updated.",
    )


TARGET = ExportTarget(
    name="ardupilot",
    title="ArduPilot Copter 4.6 or 4.7, parameter file",
    export=export,
    position_laws=("pid",),
    attitude_laws=("pid", "ardupilot"),
    options=OPTIONS,
    importer=IMPORTER,
)
