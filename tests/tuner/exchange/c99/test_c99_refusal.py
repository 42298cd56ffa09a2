"""What is infinite, NaN or overflows is refused and changes nothing; whatever finite numbers come in, finite ones go out."""

import numpy as np
import pytest

from plant.law_registry import LAWS
from plant.quadrotor.nominal import nominal
from plant.seeds import generator
from tests.tuner.exchange.c99.conftest import CASES as compiled
from tests.tuner.exchange.c99.signals import attitude_inputs, step_inputs

PREFIXES = {**{law: f"{law}_float" for law in LAWS}, "exact": "exact"}
CASES = {case: compiled[prefix] for case, prefix in PREFIXES.items()}
OK, REFUSED = 0, 1
BAD = (np.nan, np.inf, -np.inf)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("bad", BAD)
def test_every_input_is_looked_at(library, case, bad):
    """A NaN or infinity in any one member is refused, leaves the state and gives the last good output again."""
    compiled = library[PREFIXES[case]]
    for inputs, run in (
        (step_inputs(case, 4, 1), compiled.step),
        (attitude_inputs(case, 4, 1), compiled.attitude_step),
    ):
        start, good = inputs.start[:, 0], inputs.rows[:, :, 0]
        width = good.shape[1]
        for member in range(width):
            rows = np.array([good[0], good[1], good[2], good[3]])
            rows[2, member] = bad
            found = run(start, rows)
            assert list(found.status) == [OK, OK, REFUSED, OK], member
            assert found.states[2].tobytes() == found.states[1].tobytes()
            assert found.outputs[2].tobytes() == found.outputs[1].tobytes()
            # What was refused leaves no trace.
            spared = run(start, np.delete(rows, 2, axis=0))
            assert spared.outputs[2].tobytes() == found.outputs[3].tobytes()


@pytest.mark.parametrize("case", CASES)
def test_an_init_looks_at_every_input(library, case):
    compiled = library[PREFIXES[case]]
    for inputs, run in (
        (step_inputs(case, 1, 1), compiled.step),
        (attitude_inputs(case, 1, 1), compiled.attitude_step),
    ):
        for member in range(len(inputs.start)):
            start = inputs.start[:, 0].copy()
            start[member] = np.nan
            assert run(start, inputs.rows[:, :, 0]).refused, member


def test_right_after_an_init_the_output_is_hover(library):
    controller, _ = CASES["pid"]
    knowledge = nominal(controller.airframe.vehicle, controller.options, controller.control_period)
    inputs = step_inputs("hover", 1, 1)
    rows = inputs.rows[:, :, 0].copy()
    rows[0, 5] = np.nan
    found = library[PREFIXES["pid"]].step(inputs.start[:, 0], rows)
    np.testing.assert_allclose(found.outputs[0, :5], [*[knowledge.hover] * 4, 4.0 * knowledge.hover], rtol=1e-6)
    np.testing.assert_allclose(found.outputs[0, 5:], 0.0, atol=1e-7)
    attitude = attitude_inputs("hover", 1, 1)
    torque = library[PREFIXES["pid"]].attitude_step(attitude.start[:, 0], attitude.rows[:, :, 0] * np.nan)
    assert not torque.outputs.any()


def extreme(name, count, width, dtype):
    """Finite numbers of all sizes: bit patterns of the type, with some zeros, units and largest numbers among them."""
    rng = generator(9, f"tests/c99/extreme/{name}", 0)
    bits = np.uint32 if dtype is np.float32 else np.uint64
    numbers = rng.integers(0, np.iinfo(bits).max, (count, width), dtype=bits, endpoint=True).view(dtype)
    numbers = np.where(np.isfinite(numbers), numbers, dtype(1.0))
    kind = rng.integers(0, 10, (count, width))
    largest, least = np.finfo(dtype).max, np.finfo(dtype).tiny
    for i, value in enumerate((0.0, -0.0, 1.0, largest, -largest, least)):
        numbers[kind == i] = value
    # Every other row is within what flies, so that states move.
    usual = rng.standard_normal((count, width)).astype(dtype)
    numbers[::2] = usual[::2]
    return numbers


@pytest.mark.parametrize("case", CASES)
def test_finite_in_finite_out(library, case):
    compiled = library[PREFIXES[case]]
    refused = 0
    for round_ in range(4):
        for run, width, start in ((compiled.step, 32, 18), (compiled.attitude_step, 16, 6)):
            rows = extreme(f"{case}/{round_}/{width}", 3000, width, compiled.dtype)
            found = run(np.zeros(start), rows)
            assert not found.refused
            assert np.isfinite(found.outputs).all() and np.isfinite(found.states).all()
            refused += found.status.sum()
            held = np.flatnonzero(found.status[1:]) + 1
            assert found.states[held].tobytes() == found.states[held - 1].tobytes()
    assert refused > 1000


def test_rotors_keep_their_limits_whatever_comes(library):
    controller, _ = CASES["hybrid"]
    knowledge = nominal(controller.airframe.vehicle, controller.options, controller.control_period)
    found = library[PREFIXES["hybrid"]].step(np.zeros(18), extreme("limits", 5000, 32, np.float32))
    thrust = found.outputs[:, :4]
    assert thrust.min() >= np.float32(knowledge.thrust_min) and thrust.max() <= np.float32(knowledge.thrust_max)


@pytest.mark.parametrize("member", range(13))
def test_a_measurement_of_nothing_is_refused_and_left_alone(library, member):
    row = np.zeros(13)
    row[6] = 1.0
    assert library[PREFIXES["pid"]].measure(row)[0] == OK
    row[member] = np.nan
    status, found = library[PREFIXES["pid"]].measure(row)
    assert status == REFUSED and (found == 7.0).all()


@pytest.mark.parametrize("length", [0.0, 0.98, 1.02, 1e20])
def test_a_quaternion_far_from_unit_length_is_refused(library, length):
    row = np.zeros(13)
    row[6] = length
    assert library[PREFIXES["pid"]].measure(row)[0] == REFUSED


def test_a_nose_straight_up_has_no_heading(library):
    row = np.zeros(13)
    row[[6, 8]] = 0.5**0.5, -(0.5**0.5)
    assert library[PREFIXES["exact"]].measure(row)[0] in (OK, REFUSED)
    assert np.isfinite(library[PREFIXES["exact"]].measure(row)[1]).all()
