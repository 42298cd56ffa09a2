"""The equations of motion against a second implementation, conservation laws and equilibria."""

from math import pi

import numpy as np
import pytest
from harness import CALM, HUMMINGBIRD, VEHICLES, ZERO, random_quaternion
from pilot import Array, Period, Quadrotor
from scipy.spatial.transform import Rotation

from plant.closed_loop import hover_body
from plant.disturbance import Disturbance
from plant.integrator import runge_kutta_step
from plant.nominal import ControlOptions, nominal
from plant.records import flatten
from plant.rigid_body import Body, body_rate, drag_force, dynamics, gyroscopic_torque
from plant.vectors import Quaternion, Rotors, Vec3
from plant.vehicle import Vehicle

# Every term of the equations at a size that matters: the gyroscopic torque of unequal rotor speeds is made ten times that of the airframe.
RICH = HUMMINGBIRD._replace(
    inertia=Vec3(0.0034, 0.0040, 0.0060),
    rotor_inertia=1.3e-5,
    lag_up=0.0125,
    lag_down=0.025,
    drag_linear=Vec3(0.24, 0.30, 0.46),
    drag_quadratic=Vec3(0.055, 0.045, 0.065),
    rate_damping=Vec3(0.0035, 0.0039, 0.0034),
)
PERIOD, PERIODS = 0.02, 500


def vec3(a: Array) -> Vec3:
    return Vec3(*a.tolist())


def conditions(k: int) -> tuple[Array, Array, Array, Array]:
    """Wind, gust rates and injected accelerations of period k: gusty wind around 3 m/s and everything else in small."""
    t = k * PERIOD
    wind = np.array([3.0 + 2.0 * np.sin(1.3 * t), -1.5 + 2.0 * np.sin(0.7 * t + 1.0), np.sin(2.1 * t)])
    gust = 0.3 * np.sin(np.array([1.7, 2.3, 1.1]) * t)
    push = 0.5 * np.sin(np.array([0.9, 1.9, 1.4]) * t + 0.5)
    return wind, gust, push, 4.0 * push


def demand(k: int) -> tuple[Array, float, float]:
    """Thrust direction, yaw rate and climb: leaning up to 35 deg all round while yawing both ways."""
    t = k * PERIOD
    return np.array([0.7 * np.sin(2.0 * t), 0.5 * np.sin(3.1 * t)]), 2.0 * np.sin(0.8 * t), np.sin(1.1 * t)


def body_of(state: Array) -> Body:
    x, y, z, w = Rotation.from_matrix(state[6:15].reshape(3, 3)).as_quat().tolist()
    return Body(vec3(state[:3]), vec3(state[3:6]), Quaternion(w, x, y, z), vec3(state[15:18]), Rotors(*state[18:].tolist()))


def matrix_of(q: Quaternion) -> Array:
    return Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()


def test_ten_seconds_of_manoeuvre_agree_with_an_independent_integration() -> None:
    # Tolerance: at 1 ms the largest error of RK4 is that of the rotor lag, (h/tau)^4/120 = 3e-7 of a speed step of some 100 rad/s; what a
    # linear system gets wrong of it cancels in the integral, what is left is second order in the step. Measured: 1e-8 m.
    twin, f = Quadrotor(RICH), dynamics(RICH)
    state, most, tilt = twin.at_rest(), 0.0, 0.0
    body = body_of(state)
    for k in range(PERIODS):
        wind, gust, push, twist = conditions(k)
        command = twin.steer(state, *demand(k))
        state = twin.after(state, Period(command, wind, gust, push, twist), PERIOD)
        disturbance = Disturbance(vec3(wind), vec3(gust), vec3(push), vec3(twist))
        for _ in range(20):
            body = runge_kutta_step(body, Rotors(*command.tolist()), disturbance, f, 0.001)
        tilt = max(tilt, np.arccos(state[14]))
        most = max(most, float(np.abs(np.array(body.rate) - state[15:18]).max(axis=0)))
    print(tilt, state, most, np.abs(np.array(body.position) - state[:3]))
    assert 0.5 < tilt < 1.2  # the manoeuvre is one, and it is bounded
    np.testing.assert_allclose(body.position, state[:3], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(body.velocity, state[3:6], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(matrix_of(body.attitude), state[6:15].reshape(3, 3), rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(body.rotor_speed, state[18:], rtol=0.0, atol=1e-3)
