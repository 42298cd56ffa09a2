"""Sensor errors: where they enter, and their statistics."""

from math import cos, sin, sqrt

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plant.errors import InputError
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.rigid_body import Body
from plant.quadrotor.sensors import NOISE_ROWS, Noise, SensorSpec, draw_noise, measure
from plant.records import pack, rows
from plant.vectors import Quaternion, Rotors, Vec3
from tests.plant.harness import Array, random_quaternion
from tests.plant.pilot import matrix_of, vec3

FIELDS = ("position", "velocity", "attitude", "rate")
STEPS = 50_000
SILENT = pack(Noise, [0.0] * 12)


def draw(spec: SensorSpec, steps: int = STEPS, seed: int = 5) -> Array:
    out = np.empty((steps, NOISE_ROWS))
    draw_noise(spec, np.random.default_rng(seed), out)
    return out


def some_body(q: Quaternion) -> Body:
    return Body(Vec3(1.0, 2.0, 3.0), Vec3(-1.0, 0.5, 0.25), q, Vec3(0.1, 0.2, -0.3), Rotors(1.0, 1.0, 1.0, 1.0))


def test_without_noise_the_truth_is_measured() -> None:
    q = random_quaternion(np.random.default_rng(1))
    body, angles = some_body(q), euler_angles(q)
    m = measure(body, angles, body.rate, SILENT)
    assert (m.position, m.velocity, m.angles, m.rate) == (body.position, body.velocity, angles, body.rate)
    np.testing.assert_allclose(m.thrust_direction, matrix_of(q)[:, 2], rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(m.heading, [cos(angles.z), sin(angles.z), 0.0], rtol=0.0, atol=1e-14)


def test_each_error_is_added_to_its_own_quantity() -> None:
    q = random_quaternion(np.random.default_rng(2))
    body, angles = some_body(q), euler_angles(q)
    noise = pack(Noise, [0.001 * (i + 1) for i in range(12)])
    m = measure(body, angles, body.rate, noise)
    for found, truth, error in (
        (m.position, body.position, noise.position),
        (m.velocity, body.velocity, noise.velocity),
        (m.angles, angles, noise.angles),
        (m.rate, body.rate, noise.rate),
    ):
        np.testing.assert_allclose(np.array(found) - np.array(truth), error, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
@pytest.mark.parametrize("tilt", [0.0, 0.26])
def test_angle_errors_turn_the_directions_to_first_order(tilt: float, yaw: float) -> None:
    # Errors of n = 2 mrad on each axis. Level, second order is left: n^2 (1 + sqrt 2) = 1e-5 at most. Leaning by
    # `tilt`, a yaw error also turns the thrust direction, by n sin(tilt), and a pitch error turns it by cos(roll) of
    # itself: both are left out.
    n = 0.002
    bound = 1e-5 + n * (sin(tilt) + 1.0 - cos(tilt))
    for signs in ((1, 1, 1), (1, -1, 1), (-1, 1, -1)):
        error = n * np.array(signs)
        angles = np.array([yaw, 0.6 * tilt, -0.8 * tilt])
        turned = Rotation.from_euler("ZYX", angles + error[::-1]).as_matrix()
        x, y, z, w = Rotation.from_euler("ZYX", angles).as_quat().tolist()
        body = some_body(Quaternion(w, x, y, z))
        m = measure(body, euler_angles(body.attitude), body.rate, SILENT._replace(angles=vec3(error)))
        assert np.linalg.norm(m.thrust_direction - turned[:, 2], axis=0) < bound
        heading = np.array([cos(yaw + error[2]), sin(yaw + error[2]), 0.0])
        assert np.linalg.norm(m.heading - heading, axis=0) < 4e-6  # n^2


@pytest.mark.parametrize("field", FIELDS)
def test_white_noise_has_its_rms_and_is_white(field: str) -> None:
    # Over n samples the RMS is off by 1/sqrt(2 n) (one standard deviation), mean and correlations by 1/sqrt(n). 5
    # standard deviations.
    levels = {name: 0.0 for name in FIELDS} | {field: 0.3}
    noise = draw(SensorSpec(**levels))
    mine = rows(Noise, "angles" if field == "attitude" else field)
    white = noise[:, mine] / 0.3
    assert np.delete(noise, np.r_[mine], axis=1).any() == np.False_
    np.testing.assert_allclose(np.sqrt(np.mean(white**2, axis=0)), 1.0, rtol=0.0, atol=5.0 / sqrt(2 * STEPS))
    bound = 5.0 / sqrt(STEPS)
    np.testing.assert_allclose(np.mean(white, axis=0), 0.0, atol=bound)
    np.testing.assert_allclose(np.mean(white[1:] * white[:-1], axis=0), 0.0, atol=bound)
    between = np.asarray(np.corrcoef(white.T))[np.triu_indices(3, 1)]
    np.testing.assert_allclose(between, 0.0, atol=bound)


@pytest.mark.parametrize("field", FIELDS)
def test_bias_is_drawn_once_a_flight(field: str) -> None:
    # 600 flights of 3 axes: 1800 draws, RMS within 5/sqrt(3600).
    levels = {name: 0.0 for name in FIELDS} | {f"{field}_bias": 0.5}
    flights = np.array([draw(SensorSpec(**levels), 3, seed) for seed in range(600)])
    assert (flights == flights[:, :1]).all()
    mine = flights[:, 0, rows(Noise, "angles" if field == "attitude" else field)] / 0.5
    assert np.sqrt(np.mean(mine**2, axis=(0, 1))) == pytest.approx(1.0, abs=5.0 / sqrt(3600))
    assert np.count_nonzero(flights[0, 0], axis=0) == 3


def test_switching_one_sensor_off_leaves_the_bits_of_the_others() -> None:
    full, cut = draw(SensorSpec(), 100), draw(SensorSpec(rate=0.0), 100)
    gyro = rows(Noise, "rate")
    assert (cut[:, gyro] == 0.0).all()
    np.testing.assert_array_equal(np.delete(full, np.r_[gyro], axis=1), np.delete(cut, np.r_[gyro], axis=1))


def test_same_generator_state_same_bits() -> None:
    spec = SensorSpec()
    np.testing.assert_array_equal(draw(spec, 50), draw(spec, 50))
    assert (draw(spec, 50) != draw(spec, 50, seed=6)).all()


def test_silence_is_recognised() -> None:
    assert SensorSpec(0.0, 0.0, 0.0, 0.0).silent()
    assert not SensorSpec(0.0, 0.0, 0.0, 0.0, rate_bias=1e-9).silent()


@pytest.mark.parametrize("value", [-0.1, float("nan"), float("inf")])
def test_an_impossible_rms_is_refused_by_name(value: float) -> None:
    with pytest.raises(InputError, match="velocity_bias"):
        SensorSpec(velocity_bias=value)
