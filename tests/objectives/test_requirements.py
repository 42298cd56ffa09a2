"""Requirements: what counts as broken, who is flown, and that nobody else's flights change by a bit."""

from math import inf
from typing import Any

import numpy as np
import pytest

from objectives.problem import FlightBatch, Problem
from objectives.requirements import LARGEST_VIOLATION, Requirement, Screen, known_values, worth_flying
from plant.quadrotor.scenarios import SEARCH
from tests.tuner.conftest import QUICKSTART, SMALL

GROWING = [-inf, -3.0, 0.0, 1.0, 2.0, 2.5, 4.0, inf]


def requirement(limit=2.0, sense="max", hard=True, label="a"):
    return Requirement(label, "a number", "1", limit, sense, hard)


@pytest.mark.parametrize(
    ("limit", "sense", "expected"),
    [
        (2.0, "max", [0.0, 0.0, 0.0, 0.0, 0.0, 0.25, 1.0, LARGEST_VIOLATION]),
        (2.0, "min", [LARGEST_VIOLATION, 2.5, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0]),
        # Relative to 1 where the limit is 0, to its size where it is negative.
        (0.0, "max", [0.0, 0.0, 0.0, 1.0, 2.0, 2.5, 4.0, LARGEST_VIOLATION]),
        (-3.0, "max", [0.0, 0.0, 1.0, 4 / 3, 5 / 3, 5.5 / 3, 7 / 3, LARGEST_VIOLATION]),
        (-3.0, "min", [LARGEST_VIOLATION, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    ],
)
def test_violations_by_hand(limit, sense, expected):
    values = np.array(GROWING)
    asked = requirement(limit, sense)
    np.testing.assert_allclose(asked.violations(values), expected, rtol=1e-15)
    assert asked.is_satisfied(values).tolist() == [entry == 0.0 for entry in expected]


def column(values, *requirements):
    """A screen that knows the answers beforehand, one row a candidate, whatever the gains."""
    return Screen(requirements, lambda gains: np.array(values, dtype=float)[: len(gains)])


def test_screens_stand_side_by_side_and_only_hard_requirements_ground_a_candidate():
    soft, hard, last = requirement(hard=False), requirement(label="b"), requirement(0.0, "min", label="c")
    screens = (column([[9.0, 1.0]] * 3, soft, hard), column([[1.0], [-1.0], [0.0]], last))
    values = known_values(screens, np.zeros((3, 5)))
    assert values.tolist() == [[9.0, 1.0, 1.0], [9.0, 1.0, -1.0], [9.0, 1.0, 0.0]]
    assert worth_flying((soft, hard, last), values).tolist() == [True, False, True]
    assert known_values((), np.zeros((3, 5))).shape == (3, 0)
    assert worth_flying((), np.zeros((3, 0))).tolist() == [True] * 3


@pytest.mark.parametrize("wrong", [[[np.nan]], [[1.0, 2.0]], [1.0]])
def test_an_analysis_that_breaks_its_word_is_found(wrong):
    with pytest.raises(AssertionError):
        known_values((column(wrong, requirement()),), np.zeros((1, 5)))


@pytest.fixture(scope="module")
def study():
    from tuner.study.build import load_study

    return load_study(QUICKSTART, {**SMALL, "scenario.0.duration": 0.8})


def problem_of(study, screens=(), threads=2):
    return Problem(study.system, study.space, study.objectives, study.constraints, study.seed, threads, screens)


def points(study, n=5):
    return np.random.default_rng(4).uniform(size=(n, len(study.space.variables)))


def counted(problem):
    """Have the problem count how many candidates it flies each time."""
    flown, fly = [], problem.flyer.fly

    def watched(gains, *rest):
        flown.append(len(gains))
        return fly(gains, *rest)

    problem.flyer.fly = watched
    return flown


KEPT = [[1.0], [3.0], [1.0], [2.5], [2.0]]


def test_what_breaks_a_hard_requirement_is_not_flown_and_nobody_elses_bits_change(study):
    batch, asked = (FlightBatch(study.scenarios[0].spec, SEARCH, 6),), points(study)
    free = problem_of(study).evaluate(asked, batch)
    problem = problem_of(study, (column(KEPT, requirement()),))
    flown, on_flights_done = counted(problem), []
    evaluation = problem.evaluate(asked, batch, on_flights_done.append)
    keep = np.array([True, False, True, False, True])
    assert flown == [3]
    assert sum(on_flights_done) == 5 * 6
    assert (evaluation.flights, evaluation.flights_saved) == (18, 12)
    assert evaluation.flown.tolist() == keep.tolist()
    assert evaluation.requirements.tolist() == KEPT
    assert free.requirements.shape == (5, 0) and free.flown.all() and (free.flights, free.flights_saved) == (30, 0)
    for name in ("values", "failures", "scores"):
        assert np.array_equal(getattr(evaluation, name)[keep], getattr(free, name)[keep])
    # Constraints first, then the requirement, relative to its limit of 2.
    assert np.array_equal(evaluation.violations[keep, :-1], free.violations[keep])
    assert evaluation.violations[:, -1].tolist() == [0.0, 0.5, 0.0, 0.25, 0.0]
    # Failed at t = 0: failure counts 1, and every graded metric costs twice what no completed flight exceeds.
    assert (evaluation.failures[~keep] == 1.0).all()
    limits: Any = problem.system.metric_limits()
    metrics = [entry.metric.text for entry in problem.quantities]
    travel = 4.0 * limits.command_peak / study.system.timing.control_period
    for name, cost in (("failure", 1.0), ("itae.position", 3 * 2.0 * limits.position_error), ("travel", 2.0 * travel)):
        np.testing.assert_allclose(evaluation.scores[~keep, metrics.index(name)], cost, rtol=1e-12)


def test_a_held_out_check_flies_everything_and_still_tells_what_is_broken(study):
    batch, asked = (FlightBatch(study.scenarios[0].spec, SEARCH, 4),), points(study)
    free = problem_of(study).evaluate(asked, batch)
    problem = problem_of(study, (column(KEPT, requirement()),))
    everything = problem.evaluate(asked, batch, fly_all=True)
    assert everything.flown.all() and np.array_equal(everything.scores, free.scores)
    assert everything.violations[:, -1].tolist() == [0.0, 0.5, 0.0, 0.25, 0.0]
    chosen = problem.evaluate(asked, batch, fly_all=np.arange(5) == 1)
    assert chosen.flown.tolist() == [True, True, True, False, True]
    assert np.array_equal(chosen.scores[:3], free.scores[:3])


def test_a_soft_requirement_is_flown_and_counts_as_broken(study):
    batch = (FlightBatch(study.scenarios[0].spec, SEARCH, 4),)
    evaluation = problem_of(study, (column(KEPT, requirement(hard=False)),)).evaluate(points(study), batch)
    assert evaluation.flown.all()
    assert evaluation.violations[:, -1].tolist() == [0.0, 0.5, 0.0, 0.25, 0.0]


def test_same_bits_for_any_number_of_threads(study):
    batch, screens = (FlightBatch(study.scenarios[0].spec, SEARCH, 4),), (column(KEPT, requirement()),)
    one, three = (problem_of(study, screens, threads).evaluate(points(study), batch) for threads in (1, 3))
    for name in ("values", "violations", "failures", "scores", "requirements", "flown"):
        assert np.array_equal(getattr(one, name), getattr(three, name))


def test_nobody_worth_a_flight_is_an_answer_too(study):
    spec = study.scenarios[0].spec
    evaluation = problem_of(study, (column([[3.0]] * 5, requirement()),)).evaluate(
        points(study), (FlightBatch(spec, SEARCH, 4), FlightBatch(spec, SEARCH, 300))
    )
    assert evaluation.scores.shape == (5, len(study.objectives) + len(study.constraints), 304)
    assert evaluation.flights == 0 and (evaluation.failures == 1.0).all() and np.isfinite(evaluation.values).all()
