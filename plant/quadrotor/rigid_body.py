"""Equations of motion of a quadrotor: rigid body, first-order rotors, drag on the air-relative velocity.

Wu et al., Appl. Sci. 2025, 15(9), 5124, section 2, with the translational equation and the wind restored (the paper prints
neither); quaternion kinematics instead of its Euler angles, which are singular at 90 deg of pitch.
"""

from typing import NamedTuple

from plant.primitives import select
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.thrust_curve import CommandCurve, command_curve
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import (
    Quaternion,
    Rotors,
    Vec3,
    axpy3,
    axpy_quaternion,
    axpy_rotors,
    norm3,
    quaternion_rate,
    rotors_dot,
    rotors_sum,
    to_body,
    to_world,
)


class Body(NamedTuple):
    """State of the plant.

    position [m] and velocity [m/s] in world ENU; attitude: unit quaternion body -> world; rate: body rates FLU [rad/s];
    rotor_speed [rad/s].
    """

    position: Vec3
    velocity: Vec3
    attitude: Quaternion
    rate: Vec3
    rotor_speed: Rotors


class Dynamics(NamedTuple):
    """Constants of the equations of motion, inverted once a flight.

    Attributes:
        inverse_mass [1/kg].
        inverse_inertia [1/(kg m2)].
        coupling: (Iz - Iy)/Ix and so on [1].
        rotor_x, rotor_y [m].
        spin [1].
        thrust_coefficient [N s2].
        torque_ratio [m].
        rotor_inertia [kg m2].
        rise, fall: rotor poles 1/tau [1/s].
        drag_linear, drag_quadratic, drag_height, rate_damping, gravity: values as in `Vehicle`.
        curve: curve of rotor speed over its command.
        dead_time [s].
    """

    inverse_mass: float
    inverse_inertia: Vec3
    coupling: Vec3
    rotor_x: Rotors
    rotor_y: Rotors
    spin: Rotors
    thrust_coefficient: float
    torque_ratio: float
    rotor_inertia: float
    rise: float
    fall: float
    drag_linear: Vec3
    drag_quadratic: Vec3
    drag_height: float
    rate_damping: Vec3
    gravity: float
    curve: CommandCurve
    dead_time: float


def dynamics(vehicle: Vehicle) -> Dynamics:
    """Return the constants of the equations of motion of a vehicle."""
    inertia = vehicle.inertia
    return Dynamics(
        1.0 / vehicle.mass,
        Vec3(1.0 / inertia.x, 1.0 / inertia.y, 1.0 / inertia.z),
        Vec3(
            (inertia.z - inertia.y) / inertia.x,
            (inertia.x - inertia.z) / inertia.y,
            (inertia.y - inertia.x) / inertia.z,
        ),
        vehicle.rotor_x,
        vehicle.rotor_y,
        vehicle.spin,
        vehicle.thrust_coefficient,
        vehicle.torque_ratio,
        vehicle.rotor_inertia,
        1.0 / vehicle.lag_up,
        1.0 / vehicle.lag_down,
        vehicle.drag_linear,
        vehicle.drag_quadratic,
        vehicle.drag_height,
        vehicle.rate_damping,
        vehicle.gravity,
        command_curve(vehicle.thrust_linear, vehicle.speed_max),
        vehicle.dead_time,
    )


def axpy_body(a: Body, s: float, b: Body) -> Body:
    """Return a + s b, component by component."""
    return Body(
        axpy3(a.position, s, b.position),
        axpy3(a.velocity, s, b.velocity),
        axpy_quaternion(a.attitude, s, b.attitude),
        axpy3(a.rate, s, b.rate),
        axpy_rotors(a.rotor_speed, s, b.rotor_speed),
    )


def rotor_thrusts(speed: Rotors, k_f: float) -> Rotors:
    """Thrust of each rotor [N]: T_i = k_f w_i^2."""
    return Rotors(
        k_f * speed.r1 * speed.r1, k_f * speed.r2 * speed.r2, k_f * speed.r3 * speed.r3, k_f * speed.r4 * speed.r4
    )


def rotor_torque(thrust: Rotors, rotor_x: Rotors, rotor_y: Rotors, spin: Rotors, torque_ratio: float) -> Vec3:
    """Torque of the rotor thrusts on the body [N m]: lever arms about x and y, reaction about z."""
    return Vec3(rotors_dot(rotor_y, thrust), -rotors_dot(rotor_x, thrust), torque_ratio * rotors_dot(spin, thrust))


def momentum_torque(rate: Vec3, speed: Rotors, acceleration: Rotors, spin: Rotors, rotor_inertia: float) -> Vec3:
    """Torque on the body of the rotors' angular momentum (0, 0, H) [N m]: -w x (0, 0, H) - (0, 0, H').

    speed [rad/s], acceleration [rad/s2]. A rotor whose reaction torque is about +z turns about -z, so H = -J sum_i spin_i w_i.
    Rotors that speed up push the body the way their drag does, before the drag has grown: yaw leads by J / (2 k_m w).
    """
    momentum = -rotor_inertia * rotors_dot(spin, speed)
    return Vec3(-rate.y * momentum, rate.x * momentum, rotor_inertia * rotors_dot(spin, acceleration))


def drag_force(relative: Vec3, linear: Vec3, quadratic: Vec3) -> Vec3:
    """Drag [N] for an air-relative velocity [m/s], both in body axes: F_i = -(d_i + c_i |v|) v_i."""
    airspeed = norm3(relative)
    return Vec3(
        -(linear.x + quadratic.x * airspeed) * relative.x,
        -(linear.y + quadratic.y * airspeed) * relative.y,
        -(linear.z + quadratic.z * airspeed) * relative.z,
    )


def rotor_acceleration(speed: float, command: float, rise: float, fall: float) -> float:
    """First-order rotor [rad/s2]: w' = (w_c - w)/tau, with its own tau for speeding up and for slowing down."""
    return (command - speed) * select(command > speed, rise, fall)


def body_torque(
    rate: Vec3, speed: Rotors, acceleration: Rotors, thrust: Rotors, drag: Vec3, gust: Vec3, f: Dynamics
) -> Vec3:
    """Total torque on the body [N m]: thrust and reaction of the rotors, their angular momentum, drag at its centre of
    pressure, damping of the air-relative rate.
    """
    rotor = rotor_torque(thrust, f.rotor_x, f.rotor_y, f.spin, f.torque_ratio)
    spun = momentum_torque(rate, speed, acceleration, f.spin, f.rotor_inertia)
    damping, lever = f.rate_damping, f.drag_height
    return Vec3(
        rotor.x + spun.x - lever * drag.y - damping.x * (rate.x - gust.x),
        rotor.y + spun.y + lever * drag.x - damping.y * (rate.y - gust.y),
        rotor.z + spun.z - damping.z * (rate.z - gust.z),
    )


def body_rate(body: Body, command: Rotors, disturbance: Disturbance, f: Dynamics) -> Body:
    """Time derivative of the plant state; command: rotor speeds to be held [rad/s].

    m v' = R (F_drag + T e3) - m g e3, I w' = tau - w x I w (principal axes), q' = q (0, w)/2.
    """
    q, rate, speed = body.attitude, body.rate, body.rotor_speed
    spin_up = Rotors(
        rotor_acceleration(speed.r1, command.r1, f.rise, f.fall),
        rotor_acceleration(speed.r2, command.r2, f.rise, f.fall),
        rotor_acceleration(speed.r3, command.r3, f.rise, f.fall),
        rotor_acceleration(speed.r4, command.r4, f.rise, f.fall),
    )
    thrust = rotor_thrusts(speed, f.thrust_coefficient)
    relative = to_body(q, axpy3(body.velocity, -1.0, disturbance.wind))
    drag = drag_force(relative, f.drag_linear, f.drag_quadratic)
    force = to_world(q, Vec3(drag.x, drag.y, drag.z + rotors_sum(thrust)))
    torque = body_torque(rate, speed, spin_up, thrust, drag, disturbance.gust_rate, f)
    push, twist = disturbance.acceleration, disturbance.angular_acceleration
    return Body(
        body.velocity,
        Vec3(
            f.inverse_mass * force.x + push.x,
            f.inverse_mass * force.y + push.y,
            f.inverse_mass * force.z + push.z - f.gravity,
        ),
        quaternion_rate(q, rate),
        Vec3(
            f.inverse_inertia.x * torque.x - f.coupling.x * rate.y * rate.z + twist.x,
            f.inverse_inertia.y * torque.y - f.coupling.y * rate.z * rate.x + twist.y,
            f.inverse_inertia.z * torque.z - f.coupling.z * rate.x * rate.y + twist.z,
        ),
        spin_up,
    )
