"""The equations of motion against a second implementation, conservation laws and equilibria."""

from math import exp, sin

import numpy as np
import pytest

from plant.quadrotor.closed_loop import hover_body
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.integrator import runge_kutta_step
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.rigid_body import Body, axpy_body, body_rate, drag_force, dynamics, momentum_torque
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Quaternion, Rotors, Vec3
from tests.plant.harness import CALM, HUMMINGBIRD, VEHICLES, ZERO, random_quaternion
from tests.plant.pilot import Array, Period, Quadrotor, body_of, matrix_of, vec3

# Every term of the equations at a size that matters; the gyroscopic torque of unequal rotors is ten times that of the
# airframe. Drag acts 2 cm high, not 5: flown open loop, a higher one is so unstable that it multiplies any error by a
# thousand in 10 s.
RICH = HUMMINGBIRD._replace(
    drag_height=0.02,
    inertia=Vec3(0.0034, 0.0040, 0.0060),
    rotor_inertia=1.3e-5,
    lag_up=0.02,
    lag_down=0.025,
    drag_linear=Vec3(0.24, 0.30, 0.46),
    drag_quadratic=Vec3(0.055, 0.045, 0.065),
    rate_damping=Vec3(0.0035, 0.0039, 0.0034),
)
# Weightless, airless and with its rotors at rest: a free rigid body.
FREE = RICH._replace(drag_linear=ZERO, drag_quadratic=ZERO, rate_damping=ZERO, gravity=0.0)
STOPPED = Rotors(0.0, 0.0, 0.0, 0.0)
PERIOD = 0.01


def held_air(k: int) -> tuple[Array, Array, Array, Array]:
    """Wind around (3, -1.5, 0) m/s, gust rates, injected linear and angular acceleration of period k; they set in smoothly."""
    t = k * PERIOD
    onset = 1.0 - exp(-t * t)
    wind = [3.0 + 2.0 * sin(1.3 * t), -1.5 + 2.0 * sin(0.7 * t + 1.0), sin(2.1 * t)]
    gust = 0.3 * np.sin(np.array([1.7, 2.3, 1.1]) * t)
    push = 0.5 * np.sin(np.array([0.9, 1.9, 1.4]) * t + 0.5)
    return onset * np.array(wind), onset * gust, onset * push, 4.0 * onset * push


def steered(twin: Quadrotor, state: Array, k: int) -> Array:
    """Rotor commands of period k: leaning to all sides while climbing, sinking and yawing both ways."""
    t = 0.5 * k * PERIOD
    lean = np.array([0.5 * sin(2.0 * t), 0.35 * sin(3.1 * t)])
    return twin.steer(state, lean, 1.4 * sin(0.8 * t), 0.7 * sin(1.1 * t))


@pytest.mark.parametrize("seconds", [3, pytest.param(10, marks=pytest.mark.slow)])
def test_seconds_of_manoeuvre_agree_with_an_independent_integration(seconds: int) -> None:
    # What is left is the error of RK4 at 1 ms: 6.5e-9 m after 10 s, and 3.9e-10 m (16 times less) at 0.5 ms. A wrong
    # sign or a lost term shows as centimetres to metres.
    twin, f = Quadrotor(RICH), dynamics(RICH)
    state, tilt, speeds = twin.at_rest(), 0.0, 0.0
    body = body_of(state)
    for k in range(round(seconds / PERIOD)):
        wind, gust, push, twist = held_air(k)
        command = steered(twin, state, k)
        state = twin.after(state, Period(command, wind, gust, push, twist), PERIOD)
        disturbance = Disturbance(vec3(wind), vec3(gust), vec3(push), vec3(twist))
        for _ in range(10):
            body = runge_kutta_step(body, Rotors(*command.tolist()), disturbance, f, 0.001)
        tilt = max(tilt, np.arccos(state[14]))
        speeds = max(speeds, np.ptp(state[18:], axis=0))
    # The manoeuvre is one, and it is bounded.
    assert 0.5 < tilt < 1.2
    assert speeds > 10.0
    np.testing.assert_allclose(body.position, state[:3], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(body.velocity, state[3:6], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(matrix_of(body.attitude), state[6:15].reshape(3, 3), rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(body.rate, state[15:18], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(body.rotor_speed, state[18:], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("name", VEHICLES)
def test_derivative_of_any_state_agrees_with_the_rotation_matrix_form(name: str) -> None:
    # One evaluation of sums of at most ten terms: a few dozen roundings of the largest, so 1e-13 of its size.
    vehicle, rng = VEHICLES[name], np.random.default_rng(1)
    twin, hover = Quadrotor(vehicle), Quadrotor(vehicle).at_rest()
    for _ in range(20):
        q = random_quaternion(rng)
        state = np.concatenate([rng.normal(0.0, 3.0, 6), matrix_of(q).ravel(), rng.normal(0.0, 4.0, 3), hover[18:]])
        state[18:] *= rng.uniform(0.5, 1.5, 4)
        command = hover[18:] * rng.uniform(0.5, 1.5, 4)
        held = Period(command, *rng.normal(0.0, 2.0, (4, 3)))
        expected = twin.derivative(state, held)
        body = body_of(state)
        rate = body_rate(body, Rotors(*command.tolist()), Disturbance(*map(vec3, held[1:])), dynamics(vehicle))
        for found, part in ((rate.position, slice(0, 3)), (rate.velocity, slice(3, 6)), (rate.rate, slice(15, 18))):
            scale = np.abs(expected[part]).max(axis=0)
            np.testing.assert_allclose(found, expected[part], rtol=0.0, atol=1e-13 * max(1.0, scale))
        np.testing.assert_allclose(rate.rotor_speed, expected[18:], rtol=1e-13)
        # R' from q' by a central difference of the matrix, which is quadratic in q: exact to rounding, eps/step.
        ahead, back = (matrix_unscaled(axpy_body(body, s, rate).attitude) for s in (1e-3, -1e-3))
        np.testing.assert_allclose((ahead - back).ravel() / 2e-3, expected[6:15], rtol=0.0, atol=1e-11)


def matrix_unscaled(q: Quaternion) -> Array:
    """|q|^2 R(q), a polynomial of degree two in q."""
    w, x, y, z = q
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


@pytest.mark.parametrize("name", VEHICLES)
def test_hover_is_an_equilibrium(name: str) -> None:
    # Rounding only: the sum of four thrusts against the weight, relative 1e-15, and of their moments over a small
    # inertia.
    vehicle = VEHICLES[name]
    body = hover_body(nominal(vehicle, ControlOptions(), 0.004))
    rate = body_rate(body, body.rotor_speed, CALM, dynamics(vehicle))
    moment = vehicle.mass * vehicle.gravity * max(map(abs, vehicle.rotor_x))
    np.testing.assert_allclose(rate.velocity, 0.0, atol=1e-14 * vehicle.gravity)
    np.testing.assert_allclose(rate.rate, 0.0, atol=1e-15 * moment / min(vehicle.inertia))
    assert (rate.position, rate.attitude, rate.rotor_speed) == (ZERO, Quaternion(0.0, 0.0, 0.0, 0.0), STOPPED)


@pytest.mark.parametrize("name", VEHICLES)
def test_free_fall_is_a_parabola(name: str) -> None:
    # RK4 is exact for a parabola; 1000 steps add rounding of at most 1000 eps of 5 m.
    vehicle = VEHICLES[name]._replace(drag_linear=ZERO, drag_quadratic=ZERO, rate_damping=ZERO)
    attitude = random_quaternion(np.random.default_rng(2))
    body = Body(Vec3(1.0, -2.0, 3.0), Vec3(0.5, 0.25, 4.0), attitude, Vec3(0.0, 0.0, 0.0), STOPPED)
    f = dynamics(vehicle)
    for _ in range(1000):
        body = runge_kutta_step(body, STOPPED, CALM, f, 0.001)
    g = vehicle.gravity
    np.testing.assert_allclose(body.position, [1.5, -1.75, 3.0 + 4.0 - 0.5 * g], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(body.velocity, [0.5, 0.25, 4.0 - g], rtol=0.0, atol=1e-12)


def test_free_tumbling_conserves_angular_momentum_and_energy() -> None:
    # RK4 at w h = 0.006: local error (w h)^5/120 = 6e-14 per step, at most 2e-10 of the size over 3000 steps.
    inertia, f = np.array(FREE.inertia), dynamics(FREE)
    body = Body(ZERO, ZERO, Quaternion(1.0, 0.0, 0.0, 0.0), Vec3(4.0, 0.5, -3.0), STOPPED)

    def invariants(b: Body) -> Array:
        rate = np.array(b.rate)
        return np.append(matrix_of(b.attitude) @ (inertia * rate), rate @ (inertia * rate))

    before = invariants(body)
    rates = []
    for _ in range(3000):
        body = runge_kutta_step(body, STOPPED, CALM, f, 0.001)
        rates.append(body.rate)
    assert np.ptp(np.array(rates), axis=0).min(axis=0) > 0.5  # it does tumble: no rate stays constant
    np.testing.assert_allclose(invariants(body), before, rtol=0.0, atol=1e-9 * np.linalg.norm(before[:3], axis=0))


def test_spinning_rotors_do_no_work_on_the_body() -> None:
    rng = np.random.default_rng(3)
    for rate, speed in zip(rng.normal(0.0, 5.0, (100, 3)), rng.uniform(100.0, 900.0, (100, 4)), strict=True):
        torque = momentum_torque(vec3(rate), Rotors(*speed.tolist()), STOPPED, HUMMINGBIRD.spin, 1e-4)
        size = np.linalg.norm(rate, axis=0) * np.linalg.norm(torque, axis=0)
        assert abs(rate @ np.array(torque)) <= 4e-16 * size
        assert np.linalg.norm(torque, axis=0) > 0.0


def test_gyroscopic_torque_turns_the_rotor_axis_the_right_way() -> None:
    """A rotor turning about -z (reaction on the body about +z) has momentum along -z; rolling it left takes -w x H."""
    speed, spin = Rotors(500.0, 0.0, 0.0, 0.0), Rotors(1.0, -1.0, -1.0, 1.0)
    torque = momentum_torque(Vec3(2.0, 0.0, 0.0), speed, STOPPED, spin, 1e-3)
    np.testing.assert_allclose(torque, -np.cross([2.0, 0.0, 0.0], [0.0, 0.0, -0.5]), rtol=1e-15, atol=0.0)


def test_motors_that_turn_rotors_in_empty_space_keep_the_total_angular_momentum() -> None:
    # No air, so no thrust and no drag: what the rotors gain the body loses. RK4 at 1 ms over 0.2 s: 1e-10 of the momentum.
    vehicle = FREE._replace(thrust_coefficient=0.0, rotor_inertia=1e-4)
    f, spin = dynamics(vehicle), np.array(vehicle.spin)
    body = Body(ZERO, ZERO, Quaternion(1.0, 0.0, 0.0, 0.0), Vec3(0.5, -0.3, 0.2), Rotors(400.0, 500.0, 600.0, 450.0))

    def momentum(body: Body) -> Array:
        own = np.array(vehicle.inertia) * np.array(body.rate)
        own[2] -= 1e-4 * float(spin @ np.array(body.rotor_speed))
        return matrix_of(body.attitude) @ own

    before = momentum(body)
    for _ in range(200):
        body = runge_kutta_step(body, Rotors(900.0, 100.0, 300.0, 700.0), CALM, f, 0.001)
    assert max(map(abs, body.rate)) > 1.0  # the body was turned
    np.testing.assert_allclose(momentum(body), before, rtol=0.0, atol=1e-8 * np.linalg.norm(before, axis=0))


@pytest.mark.parametrize("name", ["f450", "hummingbird", "iris", "crazyflie-rotors"])
def test_yaw_leads_by_the_torque_of_accelerating_rotors(name: str) -> None:
    """Diagonal rotors asked for w0 +- d: I r' = 8 k_m w0 D + 4 J D' exactly, D = d (1 - exp(-t/tau)), for the squares cancel."""
    vehicle = VEHICLES[name]._replace(lag_up=0.02, lag_down=0.02, gravity=0.0, drag_linear=ZERO, drag_quadratic=ZERO)
    vehicle = vehicle._replace(rate_damping=ZERO)
    w0, d, tau, end = 0.5 * vehicle.speed_max, 0.05 * vehicle.speed_max, 0.02, 0.1
    body = Body(ZERO, ZERO, Quaternion(1.0, 0.0, 0.0, 0.0), ZERO, Rotors(w0, w0, w0, w0))
    command = Rotors(*[w0 + d * spin for spin in vehicle.spin])
    for _ in range(1000):
        body = runge_kutta_step(body, command, CALM, dynamics(vehicle), 1e-4)
    reached, k_m = 1.0 - exp(-end / tau), vehicle.thrust_coefficient * vehicle.torque_ratio
    angular_impulse = 8.0 * k_m * w0 * d * (end - tau * reached) + 4.0 * vehicle.rotor_inertia * d * reached
    assert body.rate.z == pytest.approx(angular_impulse / vehicle.inertia.z, rel=1e-9)


@pytest.mark.parametrize("speed", [0.1, 1.0, 8.0])
def test_drag_opposes_the_motion_and_grows_as_told(speed: float) -> None:
    linear, quadratic = Vec3(0.2, 0.3, 0.4), Vec3(0.05, 0.06, 0.07)
    for axis in range(3):
        along = [0.0, 0.0, 0.0]
        along[axis] = -speed
        force = drag_force(Vec3(*along), linear, quadratic)
        assert force[axis] == pytest.approx(linear[axis] * speed + quadratic[axis] * speed**2, rel=1e-14)
        assert sum(map(abs, force)) == abs(force[axis])


def test_wind_from_ahead_lifts_the_nose_where_drag_acts_above_the_centre_of_mass() -> None:
    """Air moving along -x pushes a high centre of pressure back: the torque is about -y, nose up (FLU)."""
    vehicle: Vehicle = HUMMINGBIRD
    body = hover_body(nominal(vehicle, ControlOptions(), 0.004))
    rate = body_rate(body, body.rotor_speed, CALM._replace(wind=Vec3(-5.0, 0.0, 0.0)), dynamics(vehicle))
    assert rate.velocity.x < 0.0
    assert rate.rate.y == pytest.approx(
        vehicle.drag_height * vehicle.mass * rate.velocity.x / vehicle.inertia.y, rel=1e-12
    )
