"""Errors of the plant side of the seed paper, each shown as a number: the printed form fails where the model stands.

Wu et al., Appl. Sci. 2025, 15(9), 5124; numbering E1 to E20 as in docs/paper.md. The laws' errors are in
test_errata_laws.py, those of the stability section in tests/tuner/extensions/theory/test_errata_theory.py.
"""

from dataclasses import replace
from itertools import product
from math import cos, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from objectives.risk.measures import Risk
from plant.air.injection import Injection
from plant.air.spec import AirSpec
from plant.backends.flyer import result_parts
from plant.errors import UnphysicalError
from plant.law_registry import LAWS
from plant.laws import hybrid, ladrc
from plant.laws.channel import Setpoint
from plant.laws.law import Law
from plant.primitives import sign
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.rules import broken_rules
from plant.quadrotor.allocation import allocate, speed_commands
from plant.quadrotor.attitude import euler_angles, thrust_direction
from plant.quadrotor.cascade import close_cascade, hovering, tilt_for
from plant.quadrotor.closed_loop import hover_body
from plant.quadrotor.integrator import runge_kutta_step
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.rigid_body import Body, body_rate, dynamics, rotor_torque
from plant.quadrotor.scenarios import ScenarioSpec, sample_scenarios
from plant.quadrotor.sensors import Noise, measure
from plant.quadrotor.vehicle import Vehicle
from plant.records import index, pack, paths
from plant.references.level import Level
from plant.references.track import Reference
from plant.vectors import Quaternion, Rotors, Vec3, axpy_quaternion, quaternion_rate, to_world
from tests.objectives.risk.resampling import paired_difference
from tests.plant import loops
from tests.plant.axis import Axis, H, defaults
from tests.plant.harness import CALM, HUMMINGBIRD, VEHICLES, ZERO, Array

LITERAL = VEHICLES["paper-literal"]
KNOW = nominal(HUMMINGBIRD, ControlOptions(), H)
STOPPED = Rotors(0.0, 0.0, 0.0, 0.0)
LEVEL = Quaternion(1.0, 0.0, 0.0, 0.0)
PRINTED_INERTIAS = [(0.0034, 0.0060, 1.302e-6), (0.0034, 0.0060, 1.302e-2)]
TRUE_INERTIA = (0.0034, 0.0034, 0.0060)


def attitude(roll: float, pitch: float, yaw: float) -> Quaternion:
    x, y, z, w = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat().tolist()
    return Quaternion(w, x, y, z)


def spinning(thrust: Array, vehicle: Vehicle, **state: Any) -> Body:
    """A body at rest and level whose rotors give these thrusts [N]; state: what differs from rest."""
    speeds = np.sqrt(np.maximum(thrust, 0.0) / vehicle.thrust_coefficient)
    return hover_body(KNOW)._replace(rotor_speed=Rotors(*speeds.tolist()), **state)


def derivative(body: Body, vehicle: Vehicle, wind: Vec3 = ZERO) -> Body:
    """The derivative of the state in steady rotors."""
    return body_rate(body, body.rotor_speed, CALM._replace(wind=wind), dynamics(vehicle))


# E1: the inertia rows of Table 2 have slipped.


def squared_distances(inertia: tuple[float, float, float]) -> Array:
    """Second moments sum m x_i^2 of the mass along each axis, (3,), from I_x = sum m (y^2 + z^2) and so on."""
    return 0.5 * np.sum(inertia, axis=0) - np.array(inertia)


@pytest.mark.parametrize("inertia", [*PRINTED_INERTIAS, TRUE_INERTIA])
def test_e01_printed_inertias_would_need_imaginary_distances(inertia: tuple[float, float, float]) -> None:
    """T15. Masses spread by (a, b, c) along the axes have the true inertia; for the printed ones a square is negative."""
    squares = squared_distances(inertia)
    refused = [rule for rule in broken_rules(HUMMINGBIRD._replace(inertia=Vec3(*inertia))) if "triangle" in rule]
    assert bool(refused) == (squares.min(axis=0) < 0.0) == (inertia != TRUE_INERTIA)
    if not refused:
        # Six point masses of 1/2 kg on the axes, and the tensor that their positions give.
        points = np.concatenate([np.diag(np.sqrt(squares)), -np.diag(np.sqrt(squares))])
        tensor = sum(0.5 * ((p @ p) * np.eye(3) - np.outer(p, p)) for p in points)
        np.testing.assert_allclose(tensor, np.diag(inertia), atol=1e-18)


def test_e01_the_triangle_rule_accepts_every_real_mass_distribution_and_nothing_else() -> None:
    rng, refusals = np.random.default_rng(1), 0
    for inertia in rng.uniform(0.0, 0.01, (300, 3)):
        refused = any(
            "triangle" in rule for rule in broken_rules(HUMMINGBIRD._replace(inertia=Vec3(*inertia.tolist())))
        )
        assert refused == (squared_distances(tuple(inertia)).min(axis=0) < 0.0)
        refusals += refused
    # Half of all triples drawn uniformly break one of three inequalities of probability 1/6 each.
    assert abs(refusals - 150) < 4 * sqrt(300 * 0.25)


def test_e01_the_default_airframe_is_the_true_one_and_the_printed_one_needs_leave() -> None:
    assert HUMMINGBIRD.inertia == TRUE_INERTIA
    assert HUMMINGBIRD.rotor_inertia == PRINTED_INERTIAS[0][2]
    with pytest.raises(UnphysicalError, match="triangle inequality: Iy"):
        load("paper-literal")
    assert load("paper-literal", allow_unphysical=True).vehicle.inertia == PRINTED_INERTIAS[0]


def test_e01_the_printed_yaw_inertia_turns_the_vehicle_five_thousand_times_too_fast() -> None:
    """The whole hover thrust on one diagonal: c m g/Iz = 40 rad/s2 on the true inertia, 1.85e5 on the printed one."""
    one_diagonal = KNOW.hover * np.array([2.0, 0.0, 0.0, 2.0])
    true, printed = (derivative(spinning(one_diagonal, v), v).rate.z for v in (HUMMINGBIRD, LITERAL))
    assert true == pytest.approx(40.2, abs=0.1)
    assert printed == pytest.approx(1.853e5, rel=1e-3)


# E9: a plus frame's torque map is printed for an X frame.

REACTION = HUMMINGBIRD.torque_ratio


def printed_torque(thrust: Array, arm: float) -> Array:
    """Equations (2) and (11) as printed, with C_q w_i^2 = (C_q/C_t) T_i."""
    t1, t2, t3, t4 = thrust
    return np.array([arm * (t2 - t4), arm * (t3 - t1), REACTION * (t1 - t2 + t3 - t4)])


def x_frame_torque(thrust: Array, arm: float) -> Array:
    """Torque about x and y by r x F for M1..M4 at 45, -45, 135, -135 degrees from ahead: left to right, front to rear."""
    azimuth = np.radians([45.0, -45.0, 135.0, -135.0])
    at = arm * np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(4)], axis=1)
    force = np.outer(thrust, [0.0, 0.0, 1.0])
    return np.cross(at, force).sum(axis=0)[:2]


MORE_LEFT = np.array([1.1, 0.9, 1.1, 0.9])
MORE_FRONT = np.array([1.1, 1.1, 0.9, 0.9])
ONE_DIAGONAL = np.array([1.1, 0.9, 0.9, 1.1])


@pytest.mark.parametrize("pattern", [MORE_LEFT, MORE_FRONT, ONE_DIAGONAL], ids=["left", "front", "diagonal"])
def test_e09_an_x_frame_turns_by_its_geometry_and_not_by_the_printed_map(pattern: Array) -> None:
    """Angular acceleration of the flown plant, times inertia, against cross products; the printed map differs by its size."""
    thrust = pattern * KNOW.hover
    torque = np.array(derivative(spinning(thrust, HUMMINGBIRD), HUMMINGBIRD).rate) * np.array(HUMMINGBIRD.inertia)
    right = x_frame_torque(thrust, 0.171)
    np.testing.assert_allclose(torque[:2], right, rtol=1e-12, atol=1e-15)
    printed = printed_torque(thrust, 0.171)
    assert np.linalg.norm(printed - torque, axis=0) > 0.5 * np.linalg.norm(torque, axis=0)


def test_e09_the_printed_map_rolls_and_pitches_where_the_papers_own_text_only_pitches() -> None:
    """Section 2: M1 and M2 faster, M3 and M4 slower is pitch. Printed, it is as much roll; of left against right it sees nothing."""
    text = printed_torque(MORE_FRONT, 0.171)
    assert abs(text[0]) == pytest.approx(abs(text[1]), rel=1e-12) and abs(text[0]) > 0.03
    np.testing.assert_allclose(printed_torque(MORE_LEFT, 0.171)[:2], 0.0, atol=1e-16)
    assert x_frame_torque(MORE_FRONT, 0.171)[0] == pytest.approx(0.0, abs=1e-16)


def test_e09_rotors_of_one_diagonal_turn_alike_so_one_diagonal_against_the_other_is_pure_yaw() -> None:
    """T16. With the signs (+, -, +, -) printed for a circular numbering, M1..M4 in rows would give no yaw at all."""
    v = HUMMINGBIRD
    torque = rotor_torque(Rotors(*ONE_DIAGONAL.tolist()), v.rotor_x, v.rotor_y, v.spin, v.torque_ratio)
    np.testing.assert_allclose(torque, [0.0, 0.0, 0.4 * REACTION], rtol=1e-12, atol=1e-16)
    assert printed_torque(ONE_DIAGONAL, 0.171)[2] == pytest.approx(0.0, abs=1e-16)


def test_e09_numbered_round_the_printed_map_is_our_plus_frame() -> None:
    """Printed 1 to 4: front, left, rear, right. Ours: front, right, left, rear."""
    v = LITERAL
    for front, left, rear, right in np.random.default_rng(2).uniform(0.5, 3.0, (20, 4)).tolist():
        torque = rotor_torque(Rotors(front, right, left, rear), v.rotor_x, v.rotor_y, v.spin, v.torque_ratio)
        np.testing.assert_allclose(torque, printed_torque(np.array([front, left, rear, right]), 0.171), rtol=1e-12)


# E10: the translational equation prints no force.


def test_e10_thrust_and_weight_accelerate_the_vehicle() -> None:
    """m v' = R (0, 0, T) - m g e3 at any attitude; the printed p' = v leaves v as it is."""
    vehicle, rng = HUMMINGBIRD._replace(drag_linear=ZERO, drag_quadratic=ZERO), np.random.default_rng(3)
    for roll, pitch, yaw, lift in rng.uniform([-1.0, -1.0, -3.0, 0.0], [1.0, 1.0, 3.0, 20.0], (50, 4)).tolist():
        body = spinning(np.full(4, lift / 4.0), vehicle, attitude=attitude(roll, pitch, yaw))
        turned = Rotation.from_euler("ZYX", [yaw, pitch, roll]).apply([0.0, 0.0, lift / 0.698])
        np.testing.assert_allclose(derivative(body, vehicle).velocity, turned - [0.0, 0.0, 9.81], rtol=0.0, atol=1e-13)


def test_e10_without_thrust_it_falls() -> None:
    """After 0.5 s at 3 m/s: 1.5 m along, as printed, and g t^2/2 = 1.23 m down, which is not."""
    vehicle = HUMMINGBIRD._replace(drag_linear=ZERO, drag_quadratic=ZERO)
    body = Body(ZERO, Vec3(3.0, 0.0, 0.0), LEVEL, ZERO, STOPPED)
    for _ in range(500):
        body = runge_kutta_step(body, STOPPED, CALM, dynamics(vehicle), 0.001)
    np.testing.assert_allclose(body.position, [1.5, 0.0, -0.5 * 9.81 * 0.25], rtol=0.0, atol=1e-12)


# E11: the expansion of R is the transpose of the R declared.


def printed_rotation(roll: float, pitch: float, yaw: float, signs: tuple[float, float, float]) -> Array:
    """Equation (4) row by row; signs of its three terms whose minus the copy at hand may have lost."""
    a, b, c = signs
    sr, cr, sp, cp, sy, cy = sin(roll), cos(roll), sin(pitch), cos(pitch), sin(yaw), cos(yaw)
    return np.array(
        [
            [cp * cy, cp * sy, a * sp],
            [sr * sp * cy + b * cr * sy, sr * sp * sy + cr * cy, sr * cp],
            [cr * sp * cy + sr * sy, cr * sp * sy + c * sr * cy, cr * cp],
        ]
    )


ANGLES = np.random.default_rng(4).uniform([-3.0, -1.4, -3.0], [3.0, 1.4, 3.0], (20, 3)).tolist()


def test_e11_whatever_its_signs_the_printed_expansion_is_not_the_declared_rotation() -> None:
    """Of eight choices of sign one is a rotation, and that is the transpose of Rz Ry Rx."""
    rotations = []
    for signs in product((1.0, -1.0), (1.0, -1.0), (1.0, -1.0)):
        matrices = [printed_rotation(r, p, y, signs) for r, p, y in ANGLES]
        declared = [Rotation.from_euler("ZYX", [y, p, r]).as_matrix() for r, p, y in ANGLES]
        assert not any(np.allclose(m, d, atol=0.01) for m, d in zip(matrices, declared, strict=True))
        if all(np.allclose(m @ m.T, np.eye(3), atol=1e-12) for m in matrices):
            rotations.append(signs)
            np.testing.assert_allclose(matrices, np.transpose(declared, (0, 2, 1)), rtol=0.0, atol=1e-14)
    assert rotations == [(-1.0, -1.0, -1.0)]


def test_e11_the_model_turns_body_into_world_as_declared() -> None:
    for roll, pitch, yaw in ANGLES:
        q = attitude(roll, pitch, yaw)
        axes = [to_world(q, Vec3(*unit)) for unit in np.eye(3).tolist()]
        printed = printed_rotation(roll, pitch, yaw, (-1.0, -1.0, -1.0))
        np.testing.assert_allclose(np.array(axes).T, printed.T, rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(thrust_direction(q), printed[2], rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(euler_angles(q), [roll, pitch, yaw], rtol=0.0, atol=1e-13)


def test_e11_with_the_printed_expansion_a_nose_down_vehicle_would_fly_backwards() -> None:
    body = spinning(np.full(4, KNOW.hover), HUMMINGBIRD, attitude=attitude(0.0, 0.1, 0.0))
    assert derivative(body, HUMMINGBIRD).velocity.x == pytest.approx(9.81 * sin(0.1), rel=1e-9)
    assert 9.81 * printed_rotation(0.0, 0.1, 0.0, (-1.0, -1.0, -1.0))[0, 2] == pytest.approx(-9.81 * sin(0.1))


def test_equations_07_and_08_are_right() -> None:
    """Printed T(eta) w against the change of the angles along the quaternion's own derivative, by central differences."""
    for (roll, pitch, yaw), rate in zip(ANGLES, np.random.default_rng(9).normal(0.0, 1.0, (20, 3)), strict=True):
        q, step = attitude(roll, pitch, yaw), 1e-6
        ends = [
            euler_angles(axpy_quaternion(q, sense * step, quaternion_rate(q, Vec3(*rate.tolist()))))
            for sense in (1, -1)
        ]
        sr, cr, tp, cp = sin(roll), cos(roll), tan(pitch), cos(pitch)
        printed = np.array([[1.0, sr * tp, cr * tp], [0.0, cr, -sr], [0.0, sr / cp, cr / cp]])
        # Rounding eps/step = 2e-10 and the step's square times third derivatives, both up to 1/cos^3 = 200 times.
        np.testing.assert_allclose((np.array(ends[0]) - ends[1]) / (2.0 * step), printed @ rate, rtol=0.0, atol=1e-7)


# E12: drag without sign and without wind.

GLIDER = HUMMINGBIRD._replace(drag_quadratic=ZERO, drag_height=0.0, gravity=0.0)


def test_e12_a_hovering_vehicle_is_blown_downwind_and_feels_nothing_when_it_drifts_along() -> None:
    """Printed, C_d v is zero for a vehicle at rest however hard it blows."""
    wind = Vec3(4.0, -2.0, 1.0)
    at_rest, drifting = (
        np.array(derivative(hover_body(KNOW)._replace(velocity=velocity), HUMMINGBIRD, wind).velocity)
        for velocity in (ZERO, wind)
    )
    assert (at_rest * np.array(wind) > 0.0).all()
    np.testing.assert_allclose(drifting, 0.0, atol=1e-13)


def test_e12_speed_through_the_air_dies_out_and_does_not_grow() -> None:
    """v = W + (v0 - W) exp(-d t/m); with the printed sign the exponent is positive: 1.4 times the speed after a second."""
    start, wind = np.array([6.0, -3.0, 2.0]), Vec3(1.0, 2.0, -0.5)
    body, f = Body(ZERO, Vec3(*start.tolist()), LEVEL, ZERO, STOPPED), dynamics(GLIDER)
    for _ in range(1000):
        body = runge_kutta_step(body, STOPPED, CALM._replace(wind=wind), f, 0.001)
    decay = np.exp(-np.array(GLIDER.drag_linear) / GLIDER.mass)
    np.testing.assert_allclose(body.velocity, np.array(wind) + (start - np.array(wind)) * decay, rtol=1e-12)


def test_e12_in_still_air_drag_only_takes_energy() -> None:
    rng = np.random.default_rng(5)
    for velocity, angles in zip(rng.normal(0.0, 5.0, (100, 3)).tolist(), rng.uniform(-1.0, 1.0, (100, 3)), strict=True):
        q = attitude(*map(float, angles))
        rate = derivative(Body(ZERO, Vec3(*velocity), q, ZERO, STOPPED), HUMMINGBIRD._replace(gravity=0.0))
        assert np.dot(velocity, rate.velocity) < 0.0


# E13: the compensation of the estimated disturbance has the wrong sign, or none.


def compensating(share: float) -> Law:
    """LADRC with `share` times its own compensation: 1 as it is, 0 none, -1 with the sign as printed."""

    def step(memory: Any, constants: Any, channel: Any, *rest: Any) -> tuple[float, Any]:
        command, z = ladrc.step(memory, constants, channel, *rest)
        return command + (1.0 - share) * z.z3 / channel.b0, z

    return replace(ladrc.LAW, step=step)


@pytest.mark.parametrize(("share", "felt"), [(1.0, 0.0), (0.0, 1.0), (-1.0, 2.0)], ids=["minus", "none", "printed"])
def test_e13_with_the_printed_sign_the_disturbance_is_felt_twice(share: float, felt: float) -> None:
    """The loop y'' = b0 (u + d) comes to rest where wc^2 e = felt b0 d: not at all, once, or twice the disturbance."""
    gains, axis = ladrc.Gains(omega_c=4.0, zeta=1.0, omega_o=20.0), Axis(b0=3.0, disturbance=0.5)
    flown = axis.fly(compensating(share), gains, round(10.0 / H), lambda t: Setpoint(0.0, 0.0, 0.0))
    assert flown.value[-1] == pytest.approx(felt * 3.0 * 0.5 / 16.0, abs=1e-10)
    assert flown.memory.z3 == pytest.approx(1.5, abs=1e-8)  # found in all three; what is done with it differs


@pytest.mark.parametrize("name", ["ladrc", "adrc", "hybrid"])
def test_e13_the_laws_command_the_disturbance_away(name: str) -> None:
    """Any stable loop at rest commands -d; only one that knows it from the observer does so without an error."""
    gains, steps = defaults(LAWS[name], "attitude"), round(20.0 / H)
    flown = Axis(b0=3.0, disturbance=0.5).fly(LAWS[name], gains, steps, lambda t: Setpoint(0.0, 0.0, 0.0))
    assert flown.command[-1] == pytest.approx(-0.5, abs=1e-6)
    assert flown.value[-1] == pytest.approx(0.0, abs=1e-8)


# E17: gain conditions of no theorem, seen from the law.


def test_e17_read_with_a_unit_the_printed_conditions_bound_the_sliding_variable_by_1_rad_per_s() -> None:
    """k1 > 2 eps/alpha, k2 > eps/alpha^2: beyond |S| = alpha^2 the term exceeds 3 eps; within, it does not hold eps off."""
    eps, alpha = 0.8, 1.0
    gains = hybrid.Gains(omega_o=10.0, lambda_=5.0, k1=2.0 * eps / alpha, k2=eps / alpha**2, delta=0.1)
    constants = hybrid.LAW.prepare(gains, H)
    for s in np.geomspace(alpha**2, 100.0, 50).tolist():
        assert hybrid.sliding_term(s, constants) >= 3.0 * eps * (1.0 - 1e-12)
    # S settles where the term equals eps: sqrt(S)^2 + 2 sqrt(S) = 1, so S = (sqrt(2) - 1)^2 = 0.17 rad/s, and not at 0.
    assert hybrid.sliding_term((sqrt(2.0) - 1.0) ** 2, constants) == pytest.approx(eps, rel=1e-12)


# E18: what y, f, g and b are.


def told_input_gains() -> list[float]:
    """What the cascade tells its six laws of their channels, in the order x, y, z, roll, pitch, yaw."""
    told: list[float] = []

    def step(memory: Any, constants: Any, channel: Any, *rest: Any) -> tuple[float, Any]:
        told.append(channel.b0)
        return 0.0, memory

    law = replace(LAWS["pid"], step=step)
    cascade = close_cascade(law, law)
    constants = cascade.prepare(loops_gains(cascade), H)
    body = hover_body(KNOW)
    seen = measure(body, euler_angles(body.attitude), body.rate, pack(Noise, [0.0] * 12))
    here = Reference(ZERO, ZERO, ZERO, 0.0, 0.0, 0.0, 0.0, 1.0)
    level = Rotors(*[KNOW.hover] * 4)
    cascade.step(cascade.start(constants, seen, KNOW, hovering(KNOW)), constants, KNOW, here, seen, level, H)
    return told


def loops_gains(cascade: Any) -> Any:
    return pack(cascade.Gains, loops.gains("pid", "pid").tolist())


def response_to_torque(torque: Array) -> Array:
    """Angular acceleration [rad/s2] of the flown plant when the rotors give hover thrust and a torque [N m]."""
    command = speed_commands(allocate(4.0 * KNOW.hover, Vec3(*torque.tolist()), KNOW), KNOW)
    return np.array(derivative(hover_body(KNOW)._replace(rotor_speed=command), HUMMINGBIRD).rate)


def response_to_demand(demand: Array) -> Array:
    """Acceleration [m/s2] of the flown plant at the tilt and thrust that the cascade's inverse finds for one [m/s2]."""
    tilt = tilt_for(Vec3(*demand.tolist()), Vec3(1.0, 0.0, 0.0), 9.81)
    lift = 0.698 * (demand[2] + 9.81) / (cos(tilt.roll) * cos(tilt.pitch))
    body = spinning(np.full(4, lift / 4.0), HUMMINGBIRD, attitude=attitude(tilt.roll, tilt.pitch, 0.0))
    return np.array(derivative(body, HUMMINGBIRD).velocity)


def test_e18_every_channel_has_a_scalar_input_gain_and_the_laws_are_told_it() -> None:
    """Central differences of the plant: diagonal, 1/I for torques and 1 for accelerations. No 12 x 4 g(x) is divided by."""
    step = 1e-3
    attitude_gain, position_gain = (
        np.array([(response(step * unit) - response(-step * unit)) / (2.0 * step) for unit in np.eye(3)])
        for response in (response_to_torque, response_to_demand)
    )
    np.testing.assert_allclose(attitude_gain, np.diag(1.0 / np.array(HUMMINGBIRD.inertia)), rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(position_gain, np.eye(3), rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(told_input_gains(), [*np.diag(position_gain), *np.diag(attitude_gain)], rtol=1e-6)


def test_e18_a_torque_moves_the_acceleration_and_not_the_angle() -> None:
    """Printed y = f + b u would jump by b u at once. Flown, the angle grows as b0 u t^2/2: by 4 in twice the time."""
    torque, angles = 1e-3, []
    body = hover_body(KNOW)
    command = speed_commands(allocate(4.0 * KNOW.hover, Vec3(torque, 0.0, 0.0), KNOW), KNOW)
    body = body._replace(rotor_speed=command)
    for _ in range(20):
        angles.append(euler_angles(body.attitude).x)
        body = runge_kutta_step(body, command, CALM, dynamics(HUMMINGBIRD), 0.001)
    t = 0.001 * np.arange(20)
    np.testing.assert_allclose(angles, 0.5 * torque / HUMMINGBIRD.inertia.x * t**2, rtol=1e-4, atol=1e-12)


# E19: words that contradict the equations beside them.


@pytest.mark.parametrize("name", ["ladrc", "adrc"])
def test_e19_the_error_is_reference_minus_estimate_as_the_equation_says(name: str) -> None:
    """The prose subtracts the other way round: the same gains then push away from the reference, ever more."""
    law, goal = LAWS[name], lambda t: Setpoint(1.0, 0.0, 0.0)

    def prose(memory: Any, constants: Any, channel: Any, *rest: Any) -> tuple[float, Any]:
        command, after = law.step(memory, constants, channel, *rest)
        z3 = (after.observer if name == "adrc" else after).z3
        return -command - 2.0 * z3 / channel.b0, after

    gains = defaults(law, "attitude")
    assert Axis().fly(law, gains, 1000, goal).value[-1] == pytest.approx(1.0, abs=1e-3)
    words = Axis().fly(replace(law, step=prose), gains, 25, goal).value
    assert (np.diff(words, n=2) < 0.0).all() and words[-1] < -0.1  # 36 rad/s2 for 0.1 s are 0.18 rad


def test_e19_the_square_root_term_is_continuous_and_only_the_sign_jumps() -> None:
    """|s|^(1/2) sgn(s), k1's term for a vanishing band: a step over zero of width 2 eps changes it by 2 sqrt(eps)."""
    constants = hybrid.LAW.prepare(hybrid.Gains(omega_o=10.0, lambda_=5.0, k1=1.0, k2=0.0, delta=1e-15), H)
    for eps in (1e-2, 1e-6, 1e-12):
        jump = hybrid.sliding_term(eps, constants) - hybrid.sliding_term(-eps, constants)
        assert jump == pytest.approx(2.0 * sqrt(eps), rel=1e-9)
        assert sign(eps) - sign(-eps) == 2.0
    # Everywhere, not only at zero: |f(a) - f(b)| <= sqrt(2 |a - b|).
    for a, b in np.random.default_rng(7).normal(0.0, 1.0, (200, 2)).tolist():
        difference = hybrid.sliding_term(a, constants) - hybrid.sliding_term(b, constants)
        assert abs(difference) <= sqrt(2.0 * abs(a - b)) * (1.0 + 1e-12)


@pytest.mark.parametrize("name", VEHICLES)
def test_e19_no_two_rotors_are_coaxial(name: str) -> None:
    at = np.stack([np.array(VEHICLES[name].rotor_x), np.array(VEHICLES[name].rotor_y)], axis=1)
    apart = np.linalg.norm(at[:, None] - at[None], axis=2)[np.triu_indices(4, 1)]
    assert apart.min(axis=0) > 0.5 * np.linalg.norm(at, axis=1).max(axis=0)


# E20: one draw of turbulence, no statistics.

DRAWS = 128
AIR = AirSpec(
    intensity="none",
    mean_wind=False,
    window=(0.0, 5.0),
    injection=Injection(angular_sigma=(1.0, 1.0, 1.0), angular_time=(0.5, 0.5, 0.5)),
)
# Printed largest pitch of ADRC over that of PID: the cell that contradicts the paper's own conclusion.
PRINTED_RATIO = 0.019 / 0.016


def pitch_peaks(scale: float, first: int = 0) -> Array:
    """Largest |pitch| [rad] of level flights through draws first.. of disturbed air; scale: of k2 of the attitude loops."""
    cascade = loops.loop().cascade
    gains = loops.gains()
    for axis in ("roll", "pitch", "yaw"):
        gains[index(cascade.Gains, f"{axis}.k2")] *= scale
    spec = ScenarioSpec("draws", 6.0, Level(), AIR)
    batch = sample_scenarios(spec, loops.VEHICLE, loops.TIMING, 7, "search", range(first, first + DRAWS))
    meters, status, _ = result_parts(loops.flyer().fly(gains[None], loops.NOMINAL, batch)[0])
    assert not status.any()
    return meters[:, paths(loops.loop().Meters).index("pitch.peak")]


def test_e20_two_draws_of_the_air_differ_by_more_than_two_printed_controllers() -> None:
    """One controller, equal gains: of all pairs of draws more than a third differ by more than ADRC from PID in Table 3."""
    peaks = pitch_peaks(1.0)
    first, second = np.triu_indices(DRAWS, 1)
    beyond = np.maximum(peaks[first] / peaks[second], peaks[second] / peaks[first]) > PRINTED_RATIO
    # Measured 0.53 over 256 draws; as a mean over pairs of 128 it scatters by some 0.05.
    assert 1.0 / 3.0 < np.mean(beyond, axis=0) < 0.75


def test_e20_one_draw_each_cannot_order_two_controllers_that_the_same_air_orders_every_time() -> None:
    """Half the k2 is worse by 4 % in the mean. In the same air it always shows; with a draw for each it is a coin toss."""
    tight, loose, other_air = pitch_peaks(1.0), pitch_peaks(0.5), pitch_peaks(0.5, first=DRAWS)
    assert (loose > tight).all()
    # Measured 0.44 over 256 draws each; the share of wrong pairs scatters by some 0.04.
    wrong = np.mean(other_air[:, None] < tight[None], axis=(0, 1))
    assert wrong > 0.3
    found = paired_difference(loose, tight, Risk("mean"), np.random.default_rng(8))
    assert 0.0 < found.low < found.difference < found.high
