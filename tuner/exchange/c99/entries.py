"""Entry points of the exported C as model functions: the code is traced from them and its golden vectors run on them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.quadrotor.attitude import euler_angles, heading_direction, nearest_turn, thrust_direction
from plant.quadrotor.cascade import Cascade, commanded_torque, hovering
from plant.quadrotor.closed_loop import select_rotors
from plant.quadrotor.nominal import Nominal, nominal
from plant.quadrotor.sensors import Measurement
from plant.records import pack, record_type
from plant.references.track import Reference
from plant.vectors import Quaternion, Rotors, Vec3, rotors_sum
from tuner.gains import Controller


class Command(NamedTuple):
    """rotor_thrust: to be put in force now [N]; thrust [N] and torque [N m] that they sum to."""

    rotor_thrust: Rotors
    thrust: float
    torque: Vec3


class AttitudeSetpoint(NamedTuple):
    """Reference of roll, pitch, yaw [rad] and yaw_rate [rad/s]."""

    roll: float
    pitch: float
    yaw: float
    yaw_rate: float


class AttitudeMeasurement(NamedTuple):
    """angles: roll, pitch, yaw [rad]; rate: body FLU [rad/s]."""

    angles: Vec3
    rate: Vec3


class AttitudeApplied(NamedTuple):
    """Last torques [N m] after the limits of the rotors, body FLU: effect and excess as in `plant.laws.channel.Applied`."""

    effect: Vec3
    excess: Vec3


@dataclass(frozen=True)
class Entries:
    """Entry points of a cascade.

    State, AttitudeState: what each keeps. init(constants, nominal, m) -> State; step(state, constants, nominal, reference, m, h)
    -> (Command, State); attitude_init(constants, m) -> AttitudeState; attitude_step(state, constants, nominal, setpoint, m,
    applied, h) -> (torque, AttitudeState).
    """

    State: Any
    AttitudeState: Any
    init: Callable[..., Any]
    step: Callable[..., Any]
    attitude_init: Callable[..., Any]
    attitude_step: Callable[..., Any]


def commanded(thrust: Rotors, nominal: Nominal) -> Command:
    """Rotor thrusts [N] with what they sum to on the nominal vehicle."""
    return Command(thrust, rotors_sum(thrust), commanded_torque(thrust, nominal.vehicle))


def measurement_of(position: Vec3, velocity: Vec3, q: Quaternion, rate: Vec3) -> Measurement:
    """Measurement of a vehicle whose attitude is known as a unit quaternion."""
    return Measurement(position, velocity, euler_angles(q), rate, thrust_direction(q), heading_direction(q))


def entries(cascade: Cascade) -> Entries:
    """Bind the entry points to a cascade."""
    Memory = cascade.attitude.Memory
    State = record_type("State", {"control": cascade.Memory, "in_force": Rotors, "pending": Rotors})
    AttitudeState = record_type(
        "AttitudeState", {"roll": Memory, "pitch": Memory, "yaw": Memory, "yaw_seen": float, "yaw_torque": float}
    )
    cascade_start, cascade_step = cascade.start, cascade.step
    law_start, law_step = cascade.attitude.start, cascade.attitude.step

    def init(constants: Any, nominal: Nominal, m: Measurement) -> Any:
        held = hovering(nominal)
        return State(cascade_start(constants, m, nominal, held), held.thrust, held.thrust)

    def step(
        state: Any, constants: Any, nominal: Nominal, reference: Reference, m: Measurement, h: float
    ) -> tuple[Command, Any]:
        command, control = cascade_step(state.control, constants, nominal, reference, m, state.in_force, h)
        in_force = select_rotors(nominal.delay > 0.5, state.pending, command)
        return commanded(in_force, nominal), State(control, in_force, command)

    def attitude_init(constants: Any, m: AttitudeMeasurement) -> Any:
        return AttitudeState(
            law_start(constants.roll, Measured(m.angles.x, m.rate.x), 0.0),
            law_start(constants.pitch, Measured(m.angles.y, m.rate.y), 0.0),
            law_start(constants.yaw, Measured(m.angles.z, m.rate.z), 0.0),
            m.angles.z,
            0.0,
        )

    def attitude_step(
        state: Any,
        constants: Any,
        nominal: Nominal,
        setpoint: AttitudeSetpoint,
        m: AttitudeMeasurement,
        applied: AttitudeApplied,
        h: float,
    ) -> tuple[Vec3, Any]:
        inertia = nominal.vehicle.inertia
        yaw_now = nearest_turn(m.angles.z, state.yaw_seen)
        goal = Setpoint(nearest_turn(setpoint.yaw, yaw_now), setpoint.yaw_rate, 0.0)
        seen, became = Measured(m.angles.x, m.rate.x), Applied(applied.effect.x, applied.excess.x)
        channel = Channel(1.0 / inertia.x, nominal.attitude_observer)
        t_x, roll = law_step(state.roll, constants.roll, channel, Setpoint(setpoint.roll, 0.0, 0.0), seen, became, h)
        seen, became = Measured(m.angles.y, m.rate.y), Applied(applied.effect.y, applied.excess.y)
        channel = Channel(1.0 / inertia.y, nominal.attitude_observer)
        t_y, pitch = law_step(
            state.pitch, constants.pitch, channel, Setpoint(setpoint.pitch, 0.0, 0.0), seen, became, h
        )
        seen, became = Measured(yaw_now, m.rate.z), Applied(applied.effect.z, applied.excess.z)
        channel = Channel(1.0 / inertia.z, nominal.attitude_observer)
        t_z, yaw = law_step(state.yaw, constants.yaw, channel, goal, seen, became, h)
        turning = nominal.yaw_smoothing * t_z + (1.0 - nominal.yaw_smoothing) * state.yaw_torque
        return Vec3(t_x, t_y, turning), AttitudeState(roll, pitch, yaw, yaw_now, turning)

    return Entries(State, AttitudeState, init, step, attitude_init, attitude_step)


def constants_of(controller: Controller) -> Any:
    """Return the constants of all loops, in float64 by the laws' `prepare`."""
    cascade = controller.cascade
    return cascade.prepare(pack(cascade.Gains, controller.gains), controller.control_period)


def nominal_of(controller: Controller) -> Nominal:
    """Nominal vehicle of the controller."""
    return nominal(controller.airframe.vehicle, controller.options, controller.control_period)
