"""The closed loop of a quadrotor and its cascade. Written once; every backend runs these functions.

With compute delay, the command decided at k comes into force at k + 1. Rotors with dead time feel it so many whole periods later
(`vehicle.late_periods`), and the gyro signal has more than the body rate (`gyro.py`); the controller models neither.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

from plant.loop import LARGEST_STATE, ClosedLoop, LoopRecords, MeterModel
from plant.primitives import absolute, both, either, select, sqrt
from plant.quadrotor.allocation import saturated, speed_commands
from plant.quadrotor.attitude import euler_angles, nearest_turn, thrust_direction
from plant.quadrotor.cascade import Cascade, Tilt, TrimCommand
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.features import BARE, VehicleFeatures
from plant.quadrotor.integrator import runge_kutta_step
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.rigid_body import Body, Dynamics, rotor_thrusts
from plant.quadrotor.rotor_line import select_rotors
from plant.quadrotor.sample import Sample, Targets
from plant.quadrotor.sensors import Noise, measure
from plant.records import record_type, rows, selector
from plant.references.track import Reference
from plant.sample import AxisSample
from plant.status import COMPLETED, LOST, NON_FINITE, TILTED
from plant.vectors import Quaternion, Rotors, Vec3, rotors_sum


class Limits(NamedTuple):
    """Largest |position error| of each tracked axis [m] and cosine of the largest tilt [1]; beyond either a flight ends."""

    position: float
    cosine_tilt: float


def hover_body(nominal: Nominal) -> Body:
    """Hover at the origin, level, at rest, with the rotors at the nominal hover speed."""
    speed = sqrt(nominal.hover / nominal.vehicle.thrust_coefficient)
    still = Vec3(0.0, 0.0, 0.0)
    return Body(still, still, Quaternion(1.0, 0.0, 0.0, 0.0), still, Rotors(speed, speed, speed, speed))


def place(body: Body, reference: Reference) -> Body:
    """The same body at the position where the reference starts."""
    return Body(reference.position, body.velocity, body.attitude, body.rate, body.rotor_speed)


def held_by(body: Body, speed: Rotors, angles: Vec3, nominal: Nominal) -> TrimCommand:
    """Return the trim command of a body; speed: of its rotors by the nominal curve [rad/s]; angles: roll, pitch, yaw [rad]."""
    vehicle = nominal.vehicle
    thrust = rotor_thrusts(speed, vehicle.thrust_coefficient)
    lift, up = rotors_sum(thrust) / vehicle.mass, thrust_direction(body.attitude)
    acceleration = Vec3(lift * up.x, lift * up.y, lift * up.z - vehicle.gravity)
    return TrimCommand(thrust, acceleration, Tilt(angles.x, angles.y))


def status_of(body: Body, reference: Reference, limits: Limits) -> float:
    """Status code of a state: 0 while the flight may go on."""
    p, v, w, goal = body.position, body.velocity, body.rate, reference.position
    size = p.x * p.x + p.y * p.y + p.z * p.z + v.x * v.x + v.y * v.y + v.z * v.z + w.x * w.x + w.y * w.y + w.z * w.z
    free = reference.hold < 0.5
    near_x = either(absolute(p.x - goal.x) < limits.position, free)
    near_y = either(absolute(p.y - goal.y) < limits.position, free)
    inside = both(both(near_x, near_y), absolute(p.z - goal.z) < limits.position)
    level = thrust_direction(body.attitude).z > limits.cosine_tilt
    return select(size < LARGEST_STATE, select(level, select(inside, COMPLETED, LOST), TILTED), NON_FINITE)


def relative_to_hover(thrust: Rotors, nominal: Nominal) -> Rotors:
    """Rotor thrusts over the hover thrust of one rotor [1]."""
    s = 1.0 / nominal.hover
    return Rotors(s * thrust.r1, s * thrust.r2, s * thrust.r3, s * thrust.r4)


def free_or(tracked: bool, reference: float, actual: float) -> AxisSample:
    """Sample of an axis that may be free: then it has no error."""
    return AxisSample(select(tracked, reference, actual), actual)


def sample_of(
    body: Body,
    angles: Vec3,
    reference: Reference,
    tilt: Tilt,
    command: Rotors,
    previous: Rotors,
    nominal: Nominal,
    time: float,
) -> Sample:
    """Return the sample for the meters; angles: true roll, pitch, yaw [rad]; tilt: the roll and pitch asked for."""
    goal, actual = reference.position, body.position
    tracked = reference.hold > 0.5
    return Sample(
        time,
        free_or(tracked, goal.x, actual.x),
        free_or(tracked, goal.y, actual.y),
        AxisSample(goal.z, actual.z),
        AxisSample(tilt.roll, angles.x),
        AxisSample(tilt.pitch, angles.y),
        AxisSample(reference.yaw, nearest_turn(angles.z, reference.yaw)),
        relative_to_hover(command, nominal),
        relative_to_hover(previous, nominal),
        saturated(command, nominal),
    )


@dataclass(frozen=True)
class CascadeLoop(ClosedLoop):
    """The closed loop of a quadrotor, bound to a cascade and to meters."""

    cascade: Cascade


def close_loop(cascade: Cascade, meter: MeterModel, features: VehicleFeatures = BARE) -> CascadeLoop:
    """Bind the closed loop to a cascade, its meters and its vehicle's features."""
    line, gyro, notches, supply = features.line, features.gyro, features.notches, features.supply
    Flight = record_type(
        "Flight",
        {
            "body": Body,
            "speed": Rotors,
            "queue": line.Queue,
            "in_force": Rotors,
            "pending": Rotors,
            "gyro": gyro.Memory,
            "notches": notches.Memory,
            "battery": supply.Memory,
            "control": cascade.Memory,
            "meters": meter.Meters,
            "status": float,
            "end_time": float,
        },
    )
    Meters = meter.Meters
    cascade_start, cascade_step = cascade.start, cascade.step
    meter_start, meter_update = meter.start, meter.update
    filled, passed = line.filled, line.passed
    gyro_start, hear = gyro.start, gyro.hear
    notches_start, follow = notches.start, notches.follow
    supply_start, feed = supply.start, supply.feed
    command_of, speed_of = features.drive
    keep_meters = selector(Meters)

    def start(
        body: Body,
        constants: Any,
        nominal: Nominal,
        reference: Reference,
        noise: Noise,
        targets: Targets,
        dynamics: Dynamics,
    ) -> Any:
        angles = euler_angles(body.attitude)
        turning = body.rotor_speed
        speed = command_of(turning, dynamics.curve)
        held = held_by(body, speed_of(speed, nominal.curve), angles, nominal)
        thrust = held.thrust
        control = cascade_start(constants, measure(body, angles, body.rate, noise), nominal, held)
        sample = sample_of(body, angles, reference, held.tilt, thrust, thrust, nominal, 0.0)
        meters = meter_start(sample, targets)
        gyro, notches, battery = gyro_start(body, nominal), notches_start(turning), supply_start(turning, nominal)
        queue = filled(speed, dynamics.dead_time)
        return Flight(body, speed, queue, thrust, thrust, gyro, notches, battery, control, meters, 0.0, 0.0)

    def decide(
        flight: Any,
        constants: Any,
        nominal: Nominal,
        reference: Reference,
        noise: Noise,
        targets: Targets,
        limits: Limits,
        time: float,
        h: float,
    ) -> Any:
        body = flight.body
        angles = euler_angles(body.attitude)
        rate, gyro = hear(flight.gyro, body, noise, nominal, h)
        m, notches = follow(flight.notches, measure(body, angles, rate, noise), body.rotor_speed, nominal, h)
        command, control = cascade_step(flight.control, constants, nominal, reference, m, flight.in_force, h)
        delayed = nominal.delay > 0.5
        in_force = select_rotors(delayed, flight.pending, command)
        flying = flight.status < 0.5
        status = select(flying, status_of(body, reference, limits), flight.status)
        alive = status < 0.5
        sample = sample_of(body, angles, reference, control.tilt, command, flight.pending, nominal, time)
        meters = keep_meters(alive, meter_update(flight.meters, sample, targets, h), flight.meters)
        end_time = select(alive, time + h, flight.end_time)
        speed_command = command_of(speed_commands(in_force, nominal), nominal.curve)
        turned_to, battery = feed(flight.battery, speed_command, body.rotor_speed, nominal, h)
        speed, queue = passed(flight.queue, turned_to, h)
        return Flight(body, speed, queue, in_force, command, gyro, notches, battery, control, meters, status, end_time)

    def advance(body: Body, speed: Rotors, disturbance: Disturbance, dynamics: Dynamics, plant_step: float) -> Body:
        return runge_kutta_step(body, speed_of(speed, dynamics.curve), disturbance, dynamics, plant_step)

    records = LoopRecords(
        cascade.Gains,
        Nominal,
        Reference,
        Disturbance,
        gyro.Noise,
        Dynamics,
        Targets,
        Limits,
        rows(Disturbance, "wind").stop,
    )
    name = f"{cascade.position.name}_{cascade.attitude.name}" + features.name
    return CascadeLoop(
        name, records, cascade.Constants, Flight, cascade.prepare, place, start, decide, advance, cascade
    )
