"""The control cascade, written once for any two laws: position -> thrust direction -> attitude -> rotor thrusts.

Six scalar channels y'' = f + b0 u. The position loops give an acceleration; it is limited to the tilt cone, turned into roll,
pitch and thrust in the heading frame, and the attitude loops give torques. Wu et al. 2025, section 2.3, leaves the map from
position to attitude open; this is the usual inverse of the thrust direction.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Law
from plant.laws.slower import slower
from plant.primitives import atan2, maximum, minimum, select, sqrt
from plant.quadrotor.allocation import allocate
from plant.quadrotor.attitude import nearest_turn
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.rigid_body import rotor_torque
from plant.quadrotor.sensors import Measurement
from plant.quadrotor.vehicle import Vehicle
from plant.records import record_type
from plant.references.track import AXES, Reference
from plant.vectors import Rotors, Vec3, axpy3, axpy_rotors, rotors_sum

POSITION_AXES, ATTITUDE_AXES = AXES[:3], AXES[3:]
# The commanded vertical specific force stays above this share of gravity, so a thrust direction always exists.
MIN_LIFT = 0.2
# Thrust is divided by the measured cosine of tilt to hold altitude, but never by less than this (60 deg).
MIN_COSINE = 0.5


class Tilt(NamedTuple):
    """Roll and pitch that the position loop asks for [rad]."""

    roll: float
    pitch: float


class TrimCommand(NamedTuple):
    """Commands that hold the vehicle at rest where a flight starts: thrust of each rotor [N] on the nominal vehicle, acceleration
    that they answer [m/s2], tilt.
    """

    thrust: Rotors
    acceleration: Vec3
    tilt: Tilt


class ActuatorModel(NamedTuple):
    """thrust: modelled rotor thrusts at the last control instant [N]; acceleration_excess [m/s2] and torque_excess [N m]:
    last command after limits minus the command asked for.
    """

    thrust: Rotors
    acceleration_excess: Vec3
    torque_excess: Vec3


def limit_to_cone(demand: Vec3, gravity: float, tangent: float) -> Vec3:
    """Shorten the horizontal part of an acceleration demand [m/s2] so that the thrust stays in the tilt cone; bound sink."""
    vertical = maximum(demand.z, (MIN_LIFT - 1.0) * gravity)
    length = sqrt(demand.x * demand.x + demand.y * demand.y + 1e-12)
    scale = minimum(1.0, tangent * (vertical + gravity) / length)
    return Vec3(scale * demand.x, scale * demand.y, vertical)


def tilt_for(acceleration: Vec3, heading: Vec3, gravity: float) -> Tilt:
    """Roll and pitch whose thrust direction gives the acceleration [m/s2], at the given heading."""
    ahead = heading.x * acceleration.x + heading.y * acceleration.y
    left = heading.x * acceleration.y - heading.y * acceleration.x
    up = acceleration.z + gravity
    return Tilt(atan2(-left, sqrt(ahead * ahead + up * up)), atan2(ahead, up))


def applied_acceleration(command: Rotors, average: Rotors, direction: Vec3, setpoint: Vec3, nominal: Nominal) -> Vec3:
    """Acceleration [m/s2] that the position observers take as their input over the last period.

    Achieved: modelled mean thrust along the measured thrust direction. Commanded: what was asked for after limits, with the
    thrust that the rotor commands sum to.
    """
    vehicle = nominal.vehicle
    lift = rotors_sum(average) / vehicle.mass
    achieved = Vec3(lift * direction.x, lift * direction.y, lift * direction.z - vehicle.gravity)
    commanded_z = rotors_sum(command) / vehicle.mass * direction.z - vehicle.gravity
    as_modeled = nominal.position_achieved > 0.5
    return Vec3(
        select(as_modeled, achieved.x, setpoint.x),
        select(as_modeled, achieved.y, setpoint.y),
        select(as_modeled, achieved.z, commanded_z),
    )


def hovering(nominal: Nominal) -> TrimCommand:
    """Commands that hold the nominal vehicle in still air."""
    hover = nominal.hover
    return TrimCommand(Rotors(hover, hover, hover, hover), Vec3(0.0, 0.0, 0.0), Tilt(0.0, 0.0))


def commanded_torque(thrust: Rotors, vehicle: Vehicle) -> Vec3:
    """Torque [N m] of rotor thrusts [N] on the nominal vehicle."""
    return rotor_torque(thrust, vehicle.rotor_x, vehicle.rotor_y, vehicle.spin, vehicle.torque_ratio)


@dataclass(frozen=True)
class Cascade:
    """A cascade bound to its laws: record types and model functions.

    prepare(gains, h) -> Constants; start(constants, measurement, nominal, held) -> Memory;
    step(memory, constants, nominal, reference, measurement, in_force, h) -> (rotor thrusts [N], Memory).
    """

    position: Law
    attitude: Law
    Gains: Any
    Constants: Any
    Memory: Any
    prepare: Callable[..., Any]
    start: Callable[..., Any]
    step: Callable[..., Any]

    @property
    def position_every(self) -> int:
        """Control periods between two steps of the position loops."""
        return self.position.every

    @property
    def at_one_rate(self) -> "Cascade":
        """The cascade with position loops at the attitude loops' rate."""
        return self if self.position.plain is None else close_cascade(self.position.plain, self.attitude)


def position_loops(law_step: Callable[..., Any]) -> Callable[..., Any]:
    """Return the step of the position loops for their law's."""

    def channel(
        memory: Any,
        constants: Any,
        nominal: Nominal,
        setpoint: Setpoint,
        value: float,
        rate: float,
        effect: float,
        excess: float,
        h: float,
    ) -> tuple[float, Any]:
        unit = Channel(1.0, nominal.position_observer)
        return law_step(memory, constants, unit, setpoint, Measured(value, rate), Applied(effect, excess), h)

    def step(
        memory: Any, constants: Any, nominal: Nominal, reference: Reference, m: Measurement, felt: Vec3, h: float
    ) -> tuple[Vec3, Any, Any, Any]:
        # In attitude mode x and y are asked for nothing.
        tracked = reference.hold > 0.5
        over = memory.actuators.acceleration_excess
        goal, speed, push = reference.position, reference.velocity, reference.acceleration
        place, moving = m.position, m.velocity
        to_x = Setpoint(select(tracked, goal.x, place.x), select(tracked, speed.x, moving.x), push.x)
        to_y = Setpoint(select(tracked, goal.y, place.y), select(tracked, speed.y, moving.y), push.y)
        to_z = Setpoint(goal.z, speed.z, push.z)
        u_x, x = channel(memory.x, constants.x, nominal, to_x, place.x, moving.x, felt.x, over.x, h)
        u_y, y = channel(memory.y, constants.y, nominal, to_y, place.y, moving.y, felt.y, over.y, h)
        u_z, z = channel(memory.z, constants.z, nominal, to_z, place.z, moving.z, felt.z, over.z, h)
        return Vec3(u_x, u_y, u_z), x, y, z

    return step


def attitude_loops(law_step: Callable[..., Any]) -> Callable[..., Any]:
    """Return the step of the attitude loops for their law's."""

    def channel(
        memory: Any,
        constants: Any,
        inertia: float,
        nominal: Nominal,
        setpoint: Setpoint,
        value: float,
        rate: float,
        effect: float,
        excess: float,
        h: float,
    ) -> tuple[float, Any]:
        unit = Channel(1.0 / inertia, nominal.attitude_observer)
        return law_step(memory, constants, unit, setpoint, Measured(value, rate), Applied(effect, excess), h)

    def step(
        memory: Any,
        constants: Any,
        nominal: Nominal,
        goal: Vec3,
        yaw_rate: float,
        angles: Vec3,
        rate: Vec3,
        felt: Vec3,
        h: float,
    ) -> tuple[Vec3, Any, Any, Any]:
        inertia, slip = nominal.vehicle.inertia, memory.actuators.torque_excess
        to_roll, to_pitch = Setpoint(goal.x, 0.0, 0.0), Setpoint(goal.y, 0.0, 0.0)
        to_yaw = Setpoint(goal.z, yaw_rate, 0.0)
        t_x, roll = channel(
            memory.roll, constants.roll, inertia.x, nominal, to_roll, angles.x, rate.x, felt.x, slip.x, h
        )
        t_y, pitch = channel(
            memory.pitch, constants.pitch, inertia.y, nominal, to_pitch, angles.y, rate.y, felt.y, slip.y, h
        )
        t_z, yaw = channel(memory.yaw, constants.yaw, inertia.z, nominal, to_yaw, angles.z, rate.z, felt.z, slip.z, h)
        return Vec3(t_x, t_y, t_z), roll, pitch, yaw

    return step


def close_cascade(position: Law, attitude: Law, position_every: int = 1) -> Cascade:
    """Bind the cascade to the laws of position and attitude loops.

    One for the same laws: derivatives and kernels are kept by cascade.

    position_every: control periods between two steps of the position loops.
    """
    # By identity: laws that compare equal may differ in their ranges.
    key = id(position), id(attitude), position_every
    if key not in _CLOSED:
        if len(_CLOSED) == MAX_CLOSED:
            del _CLOSED[next(iter(_CLOSED))]
        _CLOSED[key] = _closed(slower(position, position_every), attitude)
    return _CLOSED[key]


MAX_CLOSED = 32
_CLOSED: dict[tuple[int, int, int], Cascade] = {}
"""Cascades by the identities of their laws, which they keep alive, and the periods between steps of the position loops."""


def _closed(position: Law, attitude: Law) -> Cascade:
    laws = dict.fromkeys(POSITION_AXES, position) | dict.fromkeys(ATTITUDE_AXES, attitude)
    Gains = record_type("CascadeGains", {axis: law.Gains for axis, law in laws.items()})
    Constants = record_type("CascadeConstants", {axis: law.Constants for axis, law in laws.items()})
    memory_parts = {axis: law.Memory for axis, law in laws.items()}
    Memory = record_type(
        "CascadeMemory",
        memory_parts
        | {"actuators": ActuatorModel, "acceleration": Vec3, "tilt": Tilt, "yaw_seen": float, "yaw_torque": float},
    )
    position_prepare, attitude_prepare = position.prepare, attitude.prepare
    position_start, attitude_start = position.start, attitude.start
    step_position, step_attitude = position_loops(position.step), attitude_loops(attitude.step)

    def prepare(gains: Any, h: float) -> Any:
        return Constants(
            position_prepare(gains.x, h),
            position_prepare(gains.y, h),
            position_prepare(gains.z, h),
            attitude_prepare(gains.roll, h),
            attitude_prepare(gains.pitch, h),
            attitude_prepare(gains.yaw, h),
        )

    def start(constants: Any, m: Measurement, nominal: Nominal, held: TrimCommand) -> Any:
        angles = m.angles
        still = Vec3(0.0, 0.0, 0.0)
        push, torque, inertia = (
            held.acceleration,
            commanded_torque(held.thrust, nominal.vehicle),
            nominal.vehicle.inertia,
        )
        return Memory(
            position_start(constants.x, Measured(m.position.x, m.velocity.x), push.x),
            position_start(constants.y, Measured(m.position.y, m.velocity.y), push.y),
            position_start(constants.z, Measured(m.position.z, m.velocity.z), push.z),
            attitude_start(constants.roll, Measured(angles.x, m.rate.x), torque.x / inertia.x),
            attitude_start(constants.pitch, Measured(angles.y, m.rate.y), torque.y / inertia.y),
            attitude_start(constants.yaw, Measured(angles.z, m.rate.z), torque.z / inertia.z),
            ActuatorModel(held.thrust, still, still),
            push,
            held.tilt,
            angles.z,
            torque.z,
        )

    def step(
        memory: Any,
        constants: Any,
        nominal: Nominal,
        reference: Reference,
        m: Measurement,
        in_force: Rotors,
        h: float,
    ) -> tuple[Rotors, Any]:
        vehicle = nominal.vehicle
        gravity = vehicle.gravity
        # What the rotors delivered over the last period, as far as the controller can know.
        lagging = axpy_rotors(in_force, -1.0, memory.actuators.thrust)
        average = axpy_rotors(in_force, -nominal.lag_missing, lagging)
        thrust_now = axpy_rotors(memory.actuators.thrust, nominal.lag_step, lagging)
        direction = m.thrust_direction
        felt = applied_acceleration(in_force, average, direction, memory.acceleration, nominal)
        torque_felt = commanded_torque(average, vehicle)
        asked_for, x, y, z = step_position(memory, constants, nominal, reference, m, felt, h)
        demand = limit_to_cone(asked_for, gravity, nominal.tilt_tangent)
        tilt_setpoint = tilt_for(demand, m.heading, gravity)
        tracked = reference.hold > 0.5
        tilt = Tilt(
            select(tracked, tilt_setpoint.roll, reference.roll), select(tracked, tilt_setpoint.pitch, reference.pitch)
        )
        # The measured yaw is counted on through whole turns, so no observer sees it jump; the reference is met the short way.
        yaw_now = nearest_turn(m.angles.z, memory.yaw_seen)
        goal = Vec3(tilt.roll, tilt.pitch, nearest_turn(reference.yaw, yaw_now))
        angles = Vec3(m.angles.x, m.angles.y, yaw_now)
        wanted, roll, pitch, yaw = step_attitude(
            memory, constants, nominal, goal, reference.yaw_rate, angles, m.rate, torque_felt, h
        )
        # Rotor thrusts, and what the limits took away.
        lift = vehicle.mass * (demand.z + gravity) / maximum(direction.z, MIN_COSINE)
        smoothing = nominal.yaw_smoothing
        turning = smoothing * wanted.z + (1.0 - smoothing) * memory.yaw_torque
        torque = Vec3(wanted.x, wanted.y, turning)
        command = allocate(lift, torque, nominal)
        lift_excess = (rotors_sum(command) - lift) / vehicle.mass
        excess = Vec3(demand.x - asked_for.x, demand.y - asked_for.y, demand.z - asked_for.z + lift_excess)
        actuators = ActuatorModel(thrust_now, excess, axpy3(commanded_torque(command, vehicle), -1.0, torque))
        return command, Memory(x, y, z, roll, pitch, yaw, actuators, demand, tilt, yaw_now, turning)

    return Cascade(position, attitude, Gains, Constants, Memory, prepare, start, step)
