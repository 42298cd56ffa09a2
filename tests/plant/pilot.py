"""A second quadrotor, written from the equations and not from our code, that flies itself through a manoeuvre.

    p' = v,   m v' = R (F + T e3) - m g e3,   R' = R [w]x,   I w' = -w x I w + torques,   W' = (command - W)/tau

State as a flat vector: p 0:3, v 3:6, R 6:15 (row by row, body FLU -> world ENU), w 15:18, rotor speeds W 18:22. Attitude
is a rotation matrix, integration is DOP853 at rtol 1e-11. A rotor whose reaction on the body is about +z turns about -z.
"""

from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from plant.quadrotor.rigid_body import Body
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Quaternion, Rotors, Vec3

Array = NDArray[np.float64]
SPEED = slice(18, 22)
KP, KD = 12.0, 6.0


class Period(NamedTuple):
    """What is held constant for a while: rotor commands [rad/s], wind [m/s], gust rates [rad/s], injected accelerations."""

    command: Array
    wind: Array
    gust: Array
    push: Array
    twist: Array


def vec3(a: Array) -> Vec3:
    """Return three numbers as a Vec3."""
    return Vec3(*a.tolist())


def body_of(state: Array) -> Body:
    """Return a flat state as the model's record."""
    x, y, z, w = Rotation.from_matrix(state[6:15].reshape(3, 3)).as_quat().tolist()
    attitude = Quaternion(w, x, y, z)
    return Body(vec3(state[:3]), vec3(state[3:6]), attitude, vec3(state[15:18]), Rotors(*state[18:].tolist()))


def matrix_of(q: Quaternion) -> Array:
    """Return the rotation matrix of a quaternion."""
    return Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()


def skew(a: Array) -> Array:
    """Return the matrix of b -> a x b."""
    x, y, z = a.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


@dataclass(frozen=True)
class Quadrotor:
    """The vehicle's numbers as arrays."""

    vehicle: Vehicle

    def at_rest(self) -> Array:
        """Return hover at the origin."""
        v = self.vehicle
        speed = np.sqrt(v.mass * v.gravity / 4.0 / v.thrust_coefficient)
        return np.concatenate([np.zeros(6), np.eye(3).ravel(), np.zeros(3), np.full(4, speed)])

    @cached_property
    def mixer(self) -> Array:
        """Matrix (4, 4) from rotor thrusts to total thrust and torque: r x (0, 0, T) plus the reaction of the rotor."""
        v = self.vehicle
        arms = np.stack([np.array(v.rotor_x), np.array(v.rotor_y), np.zeros(4)], axis=1)
        torque = np.cross(arms, [0.0, 0.0, 1.0]) + np.outer(np.array(v.spin) * v.torque_ratio, [0.0, 0.0, 1.0])
        return np.vstack([np.ones(4), torque.T])

    @cached_property
    def numbers(self) -> dict[str, Array]:
        """The vehicle's vectors as arrays."""
        return {name: np.array(part) for name, part in self.vehicle._asdict().items()}

    def derivative(self, state: Array, held: Period) -> Array:
        """Return d state/dt."""
        n = self.numbers
        attitude, rate, speed = state[6:15].reshape(3, 3), state[15:18], state[SPEED]
        lift = self.mixer @ (n["thrust_coefficient"] * speed**2)
        relative = (state[3:6] - held.wind) @ attitude
        drag = -(n["drag_linear"] + n["drag_quadratic"] * sqrt(relative @ relative)) * relative
        momentum = n["inertia"] * rate
        momentum[2] -= n["rotor_inertia"] * (n["spin"] @ speed)
        spin = skew(rate)
        moment = lift[1:] + n["drag_height"] * np.array([-drag[1], drag[0], 0.0])
        moment -= n["rate_damping"] * (rate - held.gust) + spin @ momentum
        drag[2] += lift[0]
        change = np.empty_like(state)
        change[SPEED] = (held.command - speed) / np.where(held.command > speed, n["lag_up"], n["lag_down"])
        # The motors speed the rotors up against the body, which takes the opposite torque.
        moment[2] -= n["rotor_inertia"] * (-n["spin"] @ change[SPEED])
        change[:3] = state[3:6]
        change[3:6] = attitude @ drag / n["mass"] + held.push
        change[5] -= n["gravity"]
        change[6:15] = (attitude @ spin).ravel()
        change[15:18] = moment / n["inertia"] + held.twist
        return change

    def after(self, state: Array, held: Period, time: float) -> Array:
        """Return the state `time` seconds later; a command held that long is approached from one side, without a kink."""
        solution = solve_ivp(
            lambda _, y: self.derivative(y, held), (0.0, time), state, method="DOP853", rtol=1e-11, atol=1e-12
        )
        assert solution.success
        return solution.y[:, -1]

    def steer(self, state: Array, tilt: Array, turn: float, climb: float) -> Array:
        """Return rotor commands that turn towards a thrust direction (2,) and yaw rate and hold a vertical speed."""
        v = self.vehicle
        attitude, rate = state[6:15].reshape(3, 3), state[15:18]
        wanted = np.array([tilt[0], tilt[1], 1.0])
        lean = np.cross(attitude[:, 2], wanted / np.linalg.norm(wanted, axis=0))
        swing = KP * (attitude.T @ lean) - KD * rate
        swing[2] = 4.0 * (turn - rate[2])
        lift = v.mass * (v.gravity + 2.0 * (climb - state[5])) / attitude[2, 2]
        thrust = np.linalg.solve(self.mixer, np.concatenate([[lift], np.array(v.inertia) * swing]))
        return np.sqrt(np.clip(thrust / v.thrust_coefficient, v.speed_min**2, v.speed_max**2))
