"""PX4: our PID as a parameter file of QGroundControl.

Angle loop P around rate loop PI, position loop P around velocity loop PI: the form that `autopilot.pid` gives our PID, with the
same feedback. Rate gains are normalized by PX4's control allocation from the airframe's rotors (`autopilots.scales`). For an
unknown vehicle every parameter of these loops is written. PX4 1.16: src/lib/rate_control/rate_control.cpp,
mc_att_control/AttitudeControl, mc_pos_control/PositionControl.
"""

from plant.quadrotor.airframes.actuation import Actuation, actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.exchange.aboard import DERIVATIVE, OTHERS, vehicle_parameters
from tuner.exchange.target import Bundle, ExportTarget, Option, Request
from tuner.extensions.autopilots.assembly import CURVE, curve
from tuner.extensions.autopilots.parameters import Values
from tuner.extensions.autopilots.pid import rate_filters, rate_sources, setpoint_weights
from tuner.extensions.autopilots.scales import Motors, command_slope, motors, motors_text
from tuner.extensions.px4.import_ import IMPORTER
from tuner.extensions.px4.map import INTEGRAL_LIMITS, LOOP_RATE, MODEL, PX4, THRUST_MODEL, USUAL_RATE, YAW_FILTER, Px4
from tuner.extensions.px4.other_files import plain
from tuner.extensions.px4.text import read_params
from tuner.gains import Controller

FILE = PX4.file
# Its numbers of our rotors 1 to 4 in its geometry of a quad X; CA_ROTOR0 is motor 1.
MOTORS: Motors = (3, 1, 2, 4)

OPTIONS = (
    CURVE,
    Option(
        THRUST_MODEL,
        "vehicle: THR_MDL_FAC stays as it is on the vehicle, and is f where that is not known; linearised: it is f, thrust "
        "follows the command; local: it is 0, the slope at hover counts",
        ("vehicle", "linearised", "local"),
        "vehicle",
    ),
    OTHERS,
    DERIVATIVE,
    Option("vehicle", "MAVLink id of the vehicle that loads the file, 1 to 255", default="1"),
)


def export(request: Request) -> Bundle:
    """Return the parameter file; raises InputError where the gains have no form in PX4 or leave its documented ranges."""
    vehicle = request.controller.airframe.vehicle
    px4 = Px4(PX4.flying(request.controller.cascade), vehicle, actuation(vehicle, curve(request.settings)))
    present = vehicle_parameters(request, PX4.target, lambda file: read_params(plain(file)))
    rate = None if present is None else present.values.get(LOOP_RATE)
    return px4.export(
        request,
        present,
        (f"For {PX4.name}; ranges and units are those of this version.", _geometry(px4.rotors)),
        lambda values, complete: _differences(px4, request.controller, complete, values, rate),
    )


def _geometry(rotors: Actuation) -> str:
    """Return the required CA_ROTORi_* as a comment: in body FRD, KM above 0 for CCW."""
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
    px4: Px4, controller: Controller, complete: Values, values: Values, rate: float | None
) -> tuple[str, ...]:
    """Return sentences on what PX4 adds or lacks.

    Args:
        px4: PX4 on the airframe.
        controller: with our gains.
        complete: every parameter.
        values: the parameters that are written.
        rate: rate of the loops on the vehicle [Hz], None if unknown.
    """
    theirs = f"{LOOP_RATE}, default {USUAL_RATE:g} Hz" if rate is None else f"{LOOP_RATE} = {rate:g} Hz on the vehicle"
    return (
        *rate_sources(controller, yaw_filter=True),
        *_of_our_pid(px4, controller, {**complete, **values}),
        f"{_thrust(px4.rotors, complete[MODEL])}; the CA_ROTORi_* on the vehicle must describe the airframe's rotors (they "
        "are in the file as a comment).",
        f"{_rates(controller)}; PX4 runs the rate loop with the gyro "
        f"({theirs}), the attitude and position loops with their estimates, "
        "and adds their delays.",
        *_integrals(px4, complete),
        *_switched_off(values),
        "PX4's attitude error is the vector of a quaternion with sin(angle/2), its rates and speeds are limited (MC_*RATE_MAX, "
        "MPC_*_VEL_MAX, trajectories with MPC_JERK_*): equal to ours for small errors only.",
        "MPC_USE_HTE (default 1) replaces MPC_THR_HOVER by an estimate in flight, which follows the battery; our vertical gains "
        "take hover as known.",
    )


def _of_our_pid(px4: Px4, controller: Controller, values: Values) -> tuple[str, ...]:
    """Return sentences on the losses of loops that fly our PID."""
    axes = tuple(axis for axis in (*ATTITUDE_AXES, "x", "z") if axis in px4.version.names)
    if not axes:
        return ()
    weights = {axis: loop.setpoint_weight for axis, loop in px4.loops(values).items()}
    return (
        setpoint_weights({axis: weights[axis] for axis in ("x", "z", *ATTITUDE_AXES) if axis in weights}),
        f"Our derivative filters ({rate_filters(controller, axes)}) are not "
        "carried: the rate loops see the gyro through IMU_GYRO_CUTOFF (default 40 Hz, second order) and the notch filters, "
        "the velocity loops what the estimator gives.",
    )


def _rates(controller: Controller) -> str:
    period, every = 1000.0 * controller.control_period, controller.cascade.position_every
    if every == 1:
        return f"Every loop of ours runs each {period:g} ms"
    return f"Our attitude loops run each {period:g} ms, those of position each {every * period:g} ms"


def _integrals(px4: Px4, complete: Values) -> tuple[str, ...]:
    """Return sentences on the differences of the integrals."""
    if "roll" not in px4.version.names:
        return (
            "Along x and y PX4 hands the integral 2/P of the acceleration that its limits take away, where ours stops it: "
            "different only while the tilt is limited.",
        ) * ("x" not in px4.version.names)
    limits = ", ".join(f"{axis} {complete[name]:g}" for axis, name in INTEGRAL_LIMITS.items())
    return (
        "PX4 multiplies the integral gain of the rate loops by max(0, 1 - (e / 400 deg/s)^2) of the rate error e.",
        "Anti-windup differs: PX4 stops the integral of an axis that its allocation reports as saturated and clips it at "
        f"MC_*_INT_LIM ({limits} of the normalised torque), "
        "ours back-calculates with ki/kp; in the position loops PX4 back-calculates with 2/P along x and y and stops along z, "
        "where it clips at 9.81 m/s2.",
    )


def _thrust(rotors: Actuation, model: float) -> str:
    """Return the sentence on the thrust curve."""
    if model == rotors.curve:
        return f"Thrust is linearised by THR_MDL_FAC = {model:g}, right if the rotors' curve has that factor"
    return (
        f"THR_MDL_FAC is {model:g} and the rotors' curve has f = {rotors.curve:g}: torques and climb are scaled with "
        f"{command_slope(rotors, model):.4g} N per unit command, the slope at hover, and change with the throttle"
    )


def _switched_off(values: Values) -> tuple[str, ...]:
    """Return sentences on what is written only to switch something off."""
    sentences = []
    if values.get("MC_ROLLRATE_D") == values.get("MPC_XY_VEL_D_ACC") == 0.0:
        sentences.append(
            "MC_*RATE_D, MC_*RATE_FF and MPC_*_VEL_D_ACC are 0: PX4's terms on measured acceleration have no counterpart in our "
            "law (MPC_XY_VEL_D_ACC = 0 is below the documented 0.1)."
        )
    if values[YAW_FILTER] == 0.0:
        sentences.append("MC_YAW_TQ_CUTOFF is 0, because our yaw torque is not low-passed (default 2 Hz).")
    return tuple(sentences)


TARGET = ExportTarget(
    name=PX4.target,
    title=f"{PX4.name}, parameter file of QGroundControl",
    export=export,
    position_laws=("pid", "px4_position"),
    attitude_laws=("pid", "px4"),
    options=OPTIONS,
    importer=IMPORTER,
)
