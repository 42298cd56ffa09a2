"""Compiled C against the simulator's own functions, bit for bit: all laws in both loops, both entry points, both precisions."""

import numpy as np
import pytest

from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.nominal import nominal
from plant.quadrotor.rigid_body import Body
from plant.quadrotor.sensors import Noise, measure
from plant.records import flatten
from plant.vectors import Quaternion, Rotors, Vec3
from tests.tuner.exchange.c99.conftest import CASES, is_slow
from tests.tuner.exchange.c99.signals import (
    attitude_inputs,
    expected_attitude_step,
    expected_step,
    plain_attitude_step,
    plain_step,
    step_inputs,
)


def assert_same_bits(run, outputs, states):
    assert not run.refused and not run.status.any()
    kept = np.ascontiguousarray(run.states[:, : states.shape[1]])
    assert run.outputs.tobytes() == np.ascontiguousarray(outputs).tobytes()
    assert kept.tobytes() == np.ascontiguousarray(states).tobytes()
    assert run.states[:, states.shape[1] :].tobytes() == run.outputs.tobytes()


def floats(*names):
    """Cases in these types, some of them slow."""
    return [
        pytest.param(name, marks=pytest.mark.slow) if is_slow(name) else name
        for name in CASES
        if CASES[name][1] in names and name != "exact"
    ]


@pytest.mark.parametrize("case", floats("float"))
def test_cascade_in_float(library, case):
    controller, real = CASES[case]
    inputs = step_inputs(case)
    outputs, states = expected_step(controller, real, inputs)
    for lane in range(inputs.rows.shape[2]):
        run = library[case].step(inputs.start[:, lane], inputs.rows[:, :, lane])
        assert_same_bits(run, outputs[:, :, lane], states[:, :, lane])


@pytest.mark.parametrize("case", floats("float"))
def test_attitude_loops_in_float(library, case):
    controller, real = CASES[case]
    inputs = attitude_inputs(case)
    outputs, states = expected_attitude_step(controller, real, inputs)
    for lane in range(inputs.rows.shape[2]):
        run = library[case].attitude_step(inputs.start[:, lane], inputs.rows[:, :, lane])
        assert_same_bits(run, outputs[:, :, lane], states[:, :, lane])


@pytest.mark.parametrize("case", floats("double"))
def test_both_in_double_are_plain_python(library, case):
    controller, _ = CASES[case]
    inputs, attitude = step_inputs(case, 512, 2), attitude_inputs(case, 512, 2)
    for lane in range(2):
        run = library[case].step(inputs.start[:, lane], inputs.rows[:, :, lane])
        assert_same_bits(run, *plain_step(controller, inputs, lane))
        run = library[case].attitude_step(attitude.start[:, lane], attitude.rows[:, :, lane])
        assert_same_bits(run, *plain_attitude_step(controller, attitude, lane))


@pytest.mark.parametrize("case", ["pid_float", "hybrid_float", "delayed"])
def test_the_inputs_have_power(library, case):
    """Hundreds of steps keep every rotor between its limits, hundreds do not; the yaw makes whole turns. Torques have no limit."""
    controller, _ = CASES[case]
    inputs = step_inputs(case)
    outputs, _ = expected_step(controller, "float", inputs)
    limits = nominal(controller.airframe.vehicle, controller.options, controller.control_period)
    thrust = outputs[:, :4]
    inside = ((thrust > limits.thrust_min * 1.001) & (thrust < limits.thrust_max * 0.999)).all(axis=1)
    assert inside.sum() > 250 and (~inside).sum() > 80
    assert (np.abs(np.diff(inputs.rows[:, 14 + 8], axis=0)) > np.pi).any()


@pytest.mark.parametrize("real", ["float", "double"])
def test_measurement_from_a_quaternion(library, real):
    compiled = library[f"pid_{real}"]
    rows = np.random.default_rng(4).standard_normal((200, 13))
    rows[:, 6:10] /= np.linalg.norm(rows[:, 6:10], axis=1)[:, None]
    nothing = Noise(*[Vec3(0.0, 0.0, 0.0)] * 4)
    tolerance = 1e-5 if real == "float" else 1e-12
    for row in rows:
        q = Quaternion(*row[6:10].tolist())
        body = Body(Vec3(*row[:3]), Vec3(*row[3:6]), q, Vec3(*row[10:]), Rotors(0.0, 0.0, 0.0, 0.0))
        wanted = np.array(flatten(measure(body, euler_angles(q), body.rate, nothing)))
        status, found = compiled.measure(row)
        assert status == 0
        # Near the poles heading and angles amplify rounding by 1/cos(pitch).
        np.testing.assert_allclose(found, wanted, atol=tolerance / np.cos(wanted[7]) ** 2)
