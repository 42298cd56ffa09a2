"""The Runge-Kutta step: order, exactness on the rotor lag, length of the quaternion."""

from math import exp, log2, sqrt

import numpy as np
import pytest

from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.integrator import runge_kutta_step
from plant.quadrotor.rigid_body import Body, dynamics
from plant.vectors import Quaternion, Rotors, Vec3, axpy_quaternion, quaternion_rate, renormalize
from tests.plant.harness import CALM, HUMMINGBIRD, VEHICLES, ZERO
from tests.plant.pilot import Period, Quadrotor, body_of, matrix_of

# One lag for up and down: two lags make a kink where the command crosses the speed, and no method keeps its order
# across it.
SMOOTH = HUMMINGBIRD._replace(
    lag_up=0.05,
    lag_down=0.05,
    rotor_inertia=1e-5,
    drag_quadratic=Vec3(0.05, 0.04, 0.06),
    rate_damping=Vec3(0.003, 0.004, 0.005),
)


def test_halving_the_step_divides_the_error_by_sixteen() -> None:
    # Steps 16, 8 and 4 ms against a lag of 50 ms and rates of 6 rad/s: far above rounding and inside the asymptotic
    # range.
    twin = Quadrotor(SMOOTH)
    start = twin.at_rest()
    start[3:6], start[15:18] = [2.0, -1.0, 0.5], [5.0, -4.0, 3.0]
    command = start[18:] * [1.10, 0.92, 1.05, 0.97]
    held = Period(command, np.array([3.0, 4.0, -2.0]), np.array([0.2, -0.1, 0.3]), np.full(3, 0.4), np.full(3, -0.5))
    exact = twin.after(start, held, 0.48)
    f = dynamics(SMOOTH)
    disturbance = Disturbance(*[Vec3(*part.tolist()) for part in held[1:]])
    errors = []
    for h in (0.016, 0.008, 0.004):
        body = body_of(start)
        for _ in range(round(0.48 / h)):
            body = runge_kutta_step(body, Rotors(*command.tolist()), disturbance, f, h)
        motion = [*body.position, *body.velocity, *matrix_of(body.attitude).ravel(), *body.rate]
        found = np.concatenate([motion, np.array(body.rotor_speed) / 100.0])
        exact_scaled = np.concatenate([exact[:18], exact[18:] / 100.0])
        errors.append(np.linalg.norm(found - exact_scaled, axis=0))
    assert log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.2)
    assert log2(errors[1] / errors[2]) == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize("name", VEHICLES)
@pytest.mark.parametrize("factor", [1.2, 0.8])
def test_a_rotor_follows_a_step_of_its_command_exponentially(name: str, factor: float) -> None:
    # Relative error of RK4 on x' = -x/tau over one tau: (h/tau)^4/120, 1.4e-5 at the shortest lag of 5 ms; doubled as
    # a margin.
    vehicle = VEHICLES[name]
    tau = vehicle.lag_up if factor > 1.0 else vehicle.lag_down
    speed = 0.5 * vehicle.speed_max
    command = factor * speed
    still = Body(ZERO, ZERO, Quaternion(1.0, 0.0, 0.0, 0.0), ZERO, Rotors(speed, speed, speed, speed))
    f, steps = dynamics(vehicle), round(tau / 0.001)
    for _ in range(steps):
        still = runge_kutta_step(still, Rotors(command, command, command, command), CALM, f, 0.001)
    expected = command + (speed - command) * exp(-0.001 * steps / tau)
    tolerance = 2.0 * (0.001 / tau) ** 4 / 120.0
    np.testing.assert_allclose(still.rotor_speed, expected, rtol=0.0, atol=tolerance * abs(speed - command))


@pytest.mark.slow
def test_quaternion_keeps_unit_length_over_a_long_tumbling_flight() -> None:
    # Each step ends with a Newton step from |d| < 1e-13, after which only the rounding of the step itself is left: a
    # few eps.
    free = HUMMINGBIRD._replace(drag_linear=ZERO, drag_quadratic=ZERO, gravity=0.0)
    still = Rotors(0.0, 0.0, 0.0, 0.0)
    body, f, worst = (
        Body(ZERO, ZERO, Quaternion(1.0, 0.0, 0.0, 0.0), Vec3(15.0, 1.0, -12.0), still),
        dynamics(free),
        0.0,
    )
    for _ in range(15_000):
        body = runge_kutta_step(body, still, CALM, f, 0.001)
        worst = max(worst, abs(sqrt(sum(part * part for part in body.attitude)) - 1.0))
    assert worst < 1e-15


@pytest.mark.parametrize("d", [0.1, 1e-2, 1e-4, 1e-6, -1e-6, -1e-4, -1e-2, -0.1])
def test_renormalisation_leaves_the_error_that_it_claims(d: float) -> None:
    # |q|^2 = 1 + d becomes length 1 - 3 d^2/8; the next term of the series is of size d^3/8, so |d|^3 bounds the rest.
    direction = np.array([0.5, -0.1, 0.7, 0.5])
    direction /= np.linalg.norm(direction, axis=0)
    q = Quaternion(*(sqrt(1.0 + d) * direction).tolist())
    after = np.array(renormalize(q))
    length = float(np.linalg.norm(after, axis=0))
    assert length == pytest.approx(1.0 - 0.375 * d * d, abs=abs(d) ** 3 + 1e-15)
    np.testing.assert_allclose(after / length, direction, rtol=0.0, atol=1e-15)


def test_one_step_at_20_rad_per_s_leaves_the_length_as_close_as_renormalisation_needs() -> None:
    """The premise of the Newton step: |q|^2 stays within 1e-9 of 1 over a Runge-Kutta step of 1 ms."""
    h, q = 0.001, Quaternion(0.5, -0.5, 0.5, 0.5)
    rate = Vec3(12.0, -12.0, 10.583)
    k1 = quaternion_rate(q, rate)
    k2 = quaternion_rate(axpy_quaternion(q, 0.5 * h, k1), rate)
    k3 = quaternion_rate(axpy_quaternion(q, 0.5 * h, k2), rate)
    k4 = quaternion_rate(axpy_quaternion(q, h, k3), rate)
    slope = np.array([k1, k2, k3, k4]).T @ [1.0, 2.0, 2.0, 1.0] / 6.0
    assert abs(float(np.sum((np.array(q) + h * slope) ** 2, axis=0)) - 1.0) < 1e-9
