"""First generations, fronts, hypervolume and picks, against brute force. The searches have a contract of their own."""

import re

import numpy as np
import pytest

from plant.errors import InputError, UnknownNameError
from plant.seeds import generator
from tuner.search.front import feasible_front, hypervolume, non_dominated, pick, resolved_rule, weights_of
from tuner.search.initial_design import latin_hypercube


def test_latin_hypercube_fills_every_stratum_once():
    points = latin_hypercube(20, 5, generator(3, "x", 0))
    strata = np.floor(points * 20).astype(int)
    assert all(sorted(column.tolist()) == list(range(20)) for column in strata.T)


def brute_force(values):
    return [not any((other <= row).all() and (other < row).any() for other in values) for row in values]


@pytest.mark.parametrize("objectives", [1, 2, 3, 4])
def test_non_dominated_against_brute_force(objectives):
    values = np.random.default_rng(objectives).integers(0, 6, (60, objectives)).astype(float)
    assert non_dominated(values).tolist() == brute_force(values)


def test_front_leaves_out_infeasible_points_and_duplicates():
    values = np.array([[1.0, 4.0], [2.0, 2.0], [2.0, 2.0], [0.1, 0.1], [3.0, 3.0]])
    violations = np.array([[0.0], [0.0], [0.0], [1.0], [0.0]])
    assert feasible_front(values, violations).tolist() == [0, 1]
    assert feasible_front(values, violations + 1.0).tolist() == []


def test_hypervolume_by_hand_and_by_sampling():
    baseline = np.array([2.0, 10.0])
    # Scaled: (0.5, 0.5) dominates 0.6 x 0.6 of the 1.1 x 1.1 box.
    assert hypervolume(np.array([[1.0, 5.0]]), baseline) == pytest.approx(0.36 / 1.21)
    assert hypervolume(np.array([[3.0, 1.0]]), baseline) == 0.0
    assert hypervolume(np.empty((0, 2)), baseline) == 0.0
    draw = np.random.default_rng(1)
    front = draw.uniform(0.0, 2.0, (6, 3))
    samples = draw.uniform(0.0, 1.1, (200_000, 3))
    share = np.any(np.all(front[None] <= samples[:, None], axis=2), axis=1).mean(axis=0)
    # Standard error of a share from 200 000 samples: at most 0.0011; four of them.
    assert hypervolume(front, np.ones(3)) == pytest.approx(share, abs=0.0045)


@pytest.mark.parametrize("scale", [1.0, 1e-3])
@pytest.mark.parametrize("shift", [0.0, 50.0])
def test_picks_do_not_depend_on_units(scale, shift):
    values = np.array([[0.0, 10.0], [1.0, 3.0], [2.0, 2.5], [10.0, 0.0]]) * [scale, 1.0] + [shift, 0.0]
    names = ["itae", "travel"]
    assert pick("knee", values, names)[0] == 1
    assert pick("closest", values, names)[0] == 1
    assert pick("min:travel", values, names)[0] == 3
    # Scaled to 0..1 the sums 3 a + b of the four are 1, 0.6, 0.85 and 3; with b alone the last wins.
    assert pick("weights:3.0,1.0", values, names)[0] == 1
    assert pick("weights:1.0,0.0", values, names)[0] == 0
    assert pick("weights:0.0,0.5", values, names)[0] == 3
    with pytest.raises(UnknownNameError):
        pick("min:nothing", values, names)


@pytest.mark.parametrize("rule", ["knee", "closest"])
def test_of_two_points_the_one_with_the_smaller_first_objective_is_taken_and_why_is_said(rule):
    values, names = np.array([[3.0, 1.0], [2.0, 7.0]]), ["itae", "travel"]
    row, why = pick(rule, values, names)
    assert row == 1 and why.startswith("two points ") and why.endswith("so the one with the smaller itae is taken")
    assert pick(rule, values[::-1], names)[0] == 0
    # Three objectives tell two points apart, and so does a rule that looks at one.
    assert pick(rule, np.array([[3.0, 1.0, 1.0], [2.0, 7.0, 7.0]]), [*names, "yaw"])[0] == 0
    assert pick("min:travel", values, names) == (0, "smallest travel")


LABELS, ADDRESSES = ["mean(rms.x)", "worst(rms.x)", "mean(travel)"], ["rms.x", "rms.x", "travel"]
RULES = [
    ("knee", {}, "knee"),
    ("min:travel", {}, "min:mean(travel)"),
    ("min:worst(rms.x)", {}, "min:worst(rms.x)"),
    ("weights", {"travel": 2, "worst(rms.x)": 0.5}, "weights:0.0,0.5,2.0"),
    # rms.x = 1 without quotes is a table "rms" to TOML.
    ("weights", {"mean(rms": {"x)": 3}}, "weights:3.0,0.0,0.0"),
]


@pytest.mark.parametrize(("rule", "weights", "resolved"), RULES)
def test_rules_are_spelt_out(rule, weights, resolved):
    assert resolved_rule(rule, weights, LABELS, ADDRESSES) == resolved
    pick(resolved, np.random.default_rng(1).random((5, 3)), LABELS)


def test_weights_without_quotes_are_read_as_they_were_meant():
    assert weights_of({"itae": {"position": 2}}, ["cvar90(itae.position)"], ["itae.position"]) == [2.0]


BAD_RULES = [
    ("kne", {}, "rule", "did you mean 'knee'"),
    ("min:rms.x", {}, "rule", 'write "min:mean(rms.x)" or "min:worst(rms.x)"'),
    ("knee", {"travel": 1.0}, "weights", 'write rule = "weights"'),
    ("weights", {}, "weights", "no objective has a weight above 0"),
    ("weights", {"travel": 0}, "weights", "no objective has a weight above 0"),
    ("weights", {"travl": 1}, "weights.travl", "did you mean 'travel'"),
    ("weights", {"travel": -1}, "weights.travel", "0 or more"),
    ("weights", {"travel": True}, "weights.travel", "0 or more"),
    ("weights", {"travel": "1"}, "weights.travel", "0 or more"),
    ("weights", {"travel": float("nan")}, "weights.travel", "0 or more"),
    ("weights", {"rms": {"x": 1}}, "weights.rms.x", 'write "mean(rms.x)" or "worst(rms.x)"'),
]


@pytest.mark.parametrize(("rule", "weights", "key", "says"), BAD_RULES)
def test_a_bad_rule_is_refused(rule, weights, key, says):
    with pytest.raises(InputError, match=re.escape(says)) as caught:
        resolved_rule(rule, weights, LABELS, ADDRESSES)
    assert caught.value.key == key
