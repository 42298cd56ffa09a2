"""Guards on made-up results: what they must say, and when they must be silent."""

import numpy as np
import pytest

from tests.tuner.conftest import QUICKSTART
from tuner.contest.bounds import OnBound
from tuner.guards import AFTER, BEFORE, GUARDS, said_before
from tuner.guards.after import (
    constant_objectives,
    correlated_objectives,
    duplicate_knees,
    gains_on_bounds,
    idle_candidates,
)
from tuner.study import load_study

LABELS = ["error", "travel"]
RNG = np.random.default_rng


def test_a_constant_objective_is_named():
    values = np.stack([RNG(1).random(20), np.full(20, 3.0)], axis=1)
    (said,) = constant_objectives(LABELS, values)
    assert said.startswith("travel is the same for all 20 candidates flown")
    assert constant_objectives(LABELS, np.zeros((5, 2)))[0].startswith("error")
    assert constant_objectives(LABELS, RNG(2).random((20, 2))) == []
    assert constant_objectives(LABELS, values[:1]) == []
    # A tiny but real spread is not constant.
    assert constant_objectives(["error"], 1.0 + 1e-6 * RNG(3).random((9, 1))) == []


def test_objectives_that_rank_alike_are_named_whatever_the_shape():
    error = RNG(4).random(30)
    assert (
        "error and travel rank all 30" in correlated_objectives(LABELS, np.stack([error, np.exp(5 * error)], axis=1))[0]
    )
    # The opposite order is a trade-off, independence too; a constant has no ranks; few candidates may agree by chance.
    for other in (-error, RNG(5).random(30), np.ones(30)):
        assert correlated_objectives(LABELS, np.stack([error, other], axis=1)) == []
    assert correlated_objectives(LABELS, np.stack([error, error], axis=1)[:9]) == []


def replicates(offsets):
    """Finalists (3, 1 objective) whose paired differences on 500 resamples are standard normal about given offsets."""
    common = RNG(6).normal(0.0, 50.0, 500)
    noise = RNG(7).normal(0.0, 1.0, (len(offsets), 1, 500))
    noise[1] = 0.0
    return common + noise + np.array(offsets)[:, None, None]


@pytest.mark.parametrize(("away", "alike"), [(0.5, True), (1.5, True), (2.6, False), (9.0, False)])
def test_a_point_within_the_paired_interval_is_a_duplicate(away, alike):
    # 95 % of the differences lie within 1.96 of the offset; the common part of 50 must not matter.
    said = duplicate_knees(["default", "p1", "p2"], 1, [1, 2], replicates([0.0, 0.0, away]))
    assert bool(said) is alike
    assert not said or ("p1 cannot be told from p2" in said[0] and "raise held_out" in said[0])


def test_one_objective_that_differs_is_enough_and_the_default_is_not_asked():
    drawn = np.concatenate([replicates([0.0, 0.0, 0.1]), replicates([0.0, 0.0, 9.0])], axis=1)
    assert duplicate_knees(["default", "p1", "p2"], 1, [1, 2], drawn) == []
    assert duplicate_knees(["default", "p1", "p2"], 1, [1], replicates([0.0, 0.0, 0.0])) == []


def test_only_a_recommended_gain_on_an_end_that_can_be_moved_is_told():
    def on(recommended, natural):
        return OnBound("tilt.k2", "high", 30.0, 29.9, recommended, 0.5, natural)

    assert gains_on_bounds([on(True, True), on(False, False)]) == []
    (said,) = gains_on_bounds([on(True, False)])
    assert "tilt.k2 = 29.9 stands at the high end of its range, 30, as do 50 % of the front" in said


def test_idle_candidates_are_counted():
    assert idle_candidates(0, ["rms"]) == []
    assert idle_candidates(1, ["rms at most 1"])[0].startswith("1 candidate kept")
    assert "3 candidates kept" in idle_candidates(3, ["rms at most 1"])[0]


def test_the_registry_knows_when_each_speaks():
    assert {guard.when for guard in GUARDS.values()} == {BEFORE, AFTER}
    assert {
        "few_scenarios",
        "default_elsewhere",
        "rates_without_damping",
        "leading_yaw",
        "mission_floor",
        "constant_objective",
        "correlated_objectives",
        "duplicate_knee",
        "on_bound",
    } == {*GUARDS}
    assert all(guard.what and not guard.what.endswith(".") for guard in GUARDS.values())


def test_too_few_scenarios_for_the_level_are_foreseen_from_the_study_alone():
    # CVaR 0.8 asks for five in a tail of a fifth: 25.
    few = load_study(QUICKSTART, {"margin": [], "scenario.0.search": 24, "scenario.0.held_out": 25})
    (said,) = said_before(few)
    assert "rests on 24 search scenarios; 25 would put five into its tail" in said
    assert said_before(load_study(QUICKSTART, {"margin": [], "scenario.0.search": 25})) == []
