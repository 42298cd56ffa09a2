"""Bartlett's correction against the exact mean of a circle and of a radius, second derivatives, poles of richer structures."""

import numpy as np
import pytest
from scipy.stats import rice

from tuner.extensions.plant_fit import selection
from tuner.extensions.plant_fit.curvature import Curvature, bends_of, second_derivatives
from tuner.extensions.plant_fit.estimate import Problem, Projection
from tuner.extensions.plant_fit.reading import make_experiment
from tuner.extensions.plant_fit.structures import FIRST, STRUCTURES, THIRD_ZERO, extended

RADIUS, DEVIATION = 2.0, 0.2


def mean_square_of_the_distance():
    """Exact mean square of the distance of a point with normal errors from the circle on which it lies, over the variance."""
    distance = rice(RADIUS / DEVIATION, scale=DEVIATION)
    return (distance.var() + (distance.mean() - RADIUS) ** 2) / DEVIATION**2


def test_the_loss_of_a_place_on_a_circle_has_its_exact_mean():
    curved = Curvature(np.eye(1), np.full((1, 1, 1), 1.0 / RADIUS), np.zeros((1, 1, 1)), DEVIATION**2)
    exact = 2.0 - mean_square_of_the_distance()
    assert curved.mean_loss(np.ones(1), np.zeros((1, 1))) == pytest.approx(exact, abs=2e-4)
    assert exact > 1.002


def test_the_loss_of_the_radius_of_a_point_in_a_plane_has_its_exact_mean():
    flat = Curvature(np.eye(2), np.zeros((2, 2, 1)), np.zeros((2, 2, 2)), DEVIATION**2)
    bends = bends_of(lambda place: float(np.hypot(*place)), np.array([RADIUS, 0.0]), np.full(2, DEVIATION))
    assert flat.mean_loss(*bends) == pytest.approx(mean_square_of_the_distance(), abs=2e-4)


def test_second_derivatives_are_those_of_a_step_response():
    time = np.arange(40.0)
    gain, lag, dead_time = 2.0, 6.0, 2.4
    step = np.where(time < 5.0, 0.0, 1.0)
    projection = Projection(Problem.of([make_experiment(time, step, time)], 0, None, False), FIRST)
    age = np.maximum(time - 5.0 - dead_time, 0.0) / lag
    output = gain * (1.0 - np.exp(-age))
    solution = projection.solve(np.log([[lag]]), np.array([dead_time]), np.zeros(0))
    solution.linear[:] = gain, 0.0
    pairs, bends = second_derivatives(projection, solution)
    decay = np.where(age > 0.0, np.exp(-age), 0.0)
    expected = {
        (0, 0): gain * decay * (age - age**2),
        (0, 2): -age * decay,
        (1, 0): gain * decay * (1.0 - age) / lag,
        (1, 1): -gain * decay / lag**2,
        (1, 2): -decay / lag,
    }
    for pair, column in zip(pairs, bends.T, strict=True):
        first, second = pair
        known = expected.get((first, second), expected.get((second, first)))
        assert column == pytest.approx(known, abs=2e-3), pair
    assert len(pairs) == len(expected) and output.max() > 1.9


@pytest.mark.parametrize("simpler", ["first-order", "second-order", "second-order-with-a-zero", "third-order"])
@pytest.mark.parametrize(
    "richer", ["second-order-with-a-zero", "third-order-with-a-zero", "fourth-order-with-two-zeros"]
)
def test_a_richer_structure_has_the_poles_of_a_simpler_one_and_fast_ones(simpler, richer):
    small, large = STRUCTURES[simpler], STRUCTURES[richer]
    shape = np.log([[7.0, 0.9, 0.4][: small.n_shape]])
    found = extended(shape, small, large, 0.01)
    if large.order < small.order:
        assert found is None
        return
    assert found is not None
    further = [[0.01, 1.0]] * (large.order - small.order)
    expected = small.denominator(shape[0])
    for pole in further:
        expected = np.convolve(expected, pole)
    assert large.denominator(found[0]) == pytest.approx(expected, rel=1e-9)
    assert extended(shape, small, STRUCTURES["integrating"], 0.01) is None


@pytest.mark.parametrize("unit", [1e-9, 1e6])
def test_the_time_constants_of_a_record_do_not_depend_on_its_units(unit):
    time = np.arange(80.0)
    inputs = np.where((time // 10) % 2 == 1, 1.0, 0.0)
    output = np.zeros(80)
    for k in range(79):
        output[k + 1] = np.exp(-1.0 / 6.0) * output[k] + (1.0 - np.exp(-1.0 / 6.0)) * inputs[k]
    output += np.random.default_rng(1).normal(0.0, 0.01, 80)
    problems = [Problem.of([make_experiment(time, inputs, output * each)], 0, None, False) for each in (1.0, unit)]
    chosen = [selection.choose(each, [FIRST]).solution for each in problems]
    assert chosen[1].shape == pytest.approx(chosen[0].shape, abs=1e-4)
    assert chosen[1].cost == pytest.approx(unit**2 * chosen[0].cost, rel=1e-4)


def test_a_structure_whose_errors_are_in_few_blocks_is_not_taken_for_as_good():
    time = np.arange(100.0)
    step = np.where(time < 20.0, 0.0, 1.0)
    chosen = selection.choose(Problem.of([make_experiment(time, step, step)], 0, None, False), [*STRUCTURES.values()])
    assert chosen.solution.structure.integrators == 0


def test_a_richer_structure_fits_no_worse_where_the_thinned_record_hides_a_pole(monkeypatch):
    monkeypatch.setattr(selection, "REDUCED", 60)
    rng = np.random.default_rng(5)
    inputs = np.repeat(rng.choice([-1.0, 1.0], 240), 2)
    inputs[:10] = 0.0
    output, state = np.zeros(480), np.zeros(2)
    for k in range(479):
        state = np.array([0.6 * state[0] + 0.4 * inputs[k], 0.75 * state[1] + 0.25 * state[0]])
        output[k + 1] = state[1]
    problem = Problem.of(
        [make_experiment(np.arange(480.0), inputs, output + rng.normal(0.0, 0.05, 480))], 0, None, False
    )
    fits = selection._first_fits(problem, [*(each for each in STRUCTURES.values() if each.integrators == 0)])
    assert fits[THIRD_ZERO.name].cost <= 1.01 * min(each.cost for each in fits.values() if each.structure.order < 3)
