"""Angles, directions and rotations against SciPy's rotations."""

from math import pi, radians

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plant.quadrotor.attitude import euler_angles, heading_direction, nearest_turn, thrust_direction
from plant.vectors import Quaternion, Vec3, cross, norm3, quaternion_rate, to_body, to_world
from tests.plant.harness import random_quaternion
from tests.plant.pilot import matrix_of, vec3

RNG = np.random.default_rng(11)
ATTITUDES = [random_quaternion(RNG) for _ in range(100)]


def quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    x, y, z, w = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat().tolist()
    return Quaternion(w, x, y, z)


def test_euler_angles_undo_yaw_after_pitch_after_roll() -> None:
    # Near +-90 deg of pitch the angles lose half their digits; up to 85 deg the loss is a factor 1/cos = 12, so 1e-14
    # stands.
    for roll, pitch, yaw in RNG.uniform([-pi, -radians(85), -pi], [pi, radians(85), pi], (200, 3)):
        np.testing.assert_allclose(euler_angles(quaternion(roll, pitch, yaw)), [roll, pitch, yaw], rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("pitch", [pi / 2, -pi / 2])
def test_euler_angles_stay_finite_where_they_are_singular(pitch: float) -> None:
    # The sine of pitch is clipped at 1, beyond which rounding may carry it; at 1 - eps the angle is off by sqrt(2
    # eps) = 2e-8.
    for roll in (0.0, 1.0, -2.0):
        for scale in (1.0, 1.0 + 1e-15):
            q = Quaternion(*[scale * part for part in quaternion(roll, pitch, 0.3)])
            angles = euler_angles(q)
            assert np.isfinite(angles).all()
            assert angles.y == pytest.approx(pitch, abs=5e-8)


def test_rotations_between_body_and_world() -> None:
    for q in ATTITUDES:
        a = vec3(RNG.standard_normal(3))
        np.testing.assert_allclose(to_world(q, a), matrix_of(q) @ np.array(a), rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(to_body(q, a), matrix_of(q).T @ np.array(a), rtol=0.0, atol=1e-14)


def test_thrust_direction_is_the_third_column_of_the_rotation_matrix() -> None:
    for q in ATTITUDES:
        np.testing.assert_allclose(thrust_direction(q), matrix_of(q)[:, 2], rtol=0.0, atol=1e-14)


def test_heading_direction_points_along_yaw() -> None:
    for roll, pitch, yaw in RNG.uniform([-pi, -1.4, -pi], [pi, 1.4, pi], (100, 3)):
        heading = heading_direction(quaternion(roll, pitch, yaw))
        np.testing.assert_allclose(heading, [np.cos(yaw), np.sin(yaw), 0.0], rtol=0.0, atol=1e-13)


def test_positive_pitch_leans_forward_and_positive_roll_to_the_right() -> None:
    # x'' = g theta and y'' = -g phi to first order in FLU.
    assert thrust_direction(quaternion(0.0, 0.1, 0.0)).x == pytest.approx(np.sin(0.1), rel=1e-12)
    assert thrust_direction(quaternion(0.1, 0.0, 0.0)).y == pytest.approx(-np.sin(0.1), rel=1e-12)


def test_quaternion_rate_is_the_derivative_of_turning_in_the_body() -> None:
    # Central difference of q(t) = q0 exp(w t): error (|w| t)^2/24 of |w|/2, 2e-10, plus rounding eps/t = 2e-12.
    step = 1e-4
    for q in ATTITUDES:
        rate = RNG.uniform(-1.0, 1.0, 3)
        start = Rotation.from_quat([q.x, q.y, q.z, q.w])
        ends = [(start * Rotation.from_rotvec(s * step * rate)).as_quat()[[3, 0, 1, 2]] for s in (1.0, -1.0)]
        ends = [end * np.sign(end @ np.array(q)) for end in ends]  # q and -q are the same attitude
        np.testing.assert_allclose(
            quaternion_rate(q, vec3(rate)), (ends[0] - ends[1]) / (2 * step), rtol=0.0, atol=1e-9
        )


def test_cross_product_and_length() -> None:
    for a, b in RNG.standard_normal((50, 2, 3)):
        np.testing.assert_allclose(cross(vec3(a), vec3(b)), np.cross(a, b), rtol=0.0, atol=1e-14)
        assert norm3(vec3(a)) == pytest.approx(float(np.linalg.norm(a, axis=0)), rel=1e-15)
    assert norm3(Vec3(3.0, 0.0, -4.0)) == 5.0


@pytest.mark.parametrize("turns", [-50, -1, 0, 1, 7])
def test_nearest_turn_comes_within_half_a_turn_of_the_reference(turns: int) -> None:
    for angle, offset in RNG.uniform(-pi, pi, (100, 2)):
        reference = angle + offset + turns * 2.0 * pi
        found = nearest_turn(angle, reference)
        assert abs(found - reference) <= pi + 1e-12
        assert (found - angle) / (2.0 * pi) == pytest.approx(turns + round((offset) / (2.0 * pi)), abs=1e-12)


def test_nearest_turn_leaves_a_close_angle_alone() -> None:
    assert nearest_turn(0.3, 0.25) == 0.3
    assert nearest_turn(-3.0, 0.1) == -3.0
