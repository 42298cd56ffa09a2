"""What is shown and said where nothing was feasible, on made-up archives."""

import numpy as np
import pytest

from objectives.evaluator import Constraint, Objective
from objectives.metrics import parse
from objectives.requirements import Requirement, requirement_excess
from objectives.risk import Risk
from tuner.search.infeasible import nothing_feasible
from tuner.search.loop import Archive

BOUND = Requirement("bound", "a bound", "rad", 2.0, "max")
RATE = Requirement("rate", "a rate", "1", 10.0, "min", hard=False)


def archive(constraints, known, requirements, flown):
    violations = np.concatenate([constraints, np.maximum(requirement_excess(requirements, known), 0.0)], axis=1)
    n = len(constraints)
    return Archive(np.zeros((n, 1)), np.zeros((n, 2)), violations, known, np.array(flown))


def test_without_requirements_the_constraints_decide():
    found = archive(np.array([[3.0, 0.0], [0.5, 1.0], [1.5, 0.0]]), np.empty((3, 0)), (), [True] * 3)
    least, why = nothing_feasible(found, ())
    assert least == 1  # the first of two that break by 1.5 in all
    assert why == []


def test_constraints_of_different_units_count_relative_to_their_limits():
    # An overshoot of 16 % against 15 %, and a settling time of 0.6 s against 0.3 s: 7 % and 100 % beyond.
    limits = [Constraint(Objective(parse("overshoot.x"), Risk("mean")), 15.0)]
    limits += [Constraint(Objective(parse("settling.x"), Risk("mean")), 0.3)]
    found = archive(np.array([[0.0, 0.3], [1.0, 0.0]]), np.empty((2, 0)), (), [True] * 2)
    assert nothing_feasible(found, (), limits)[0] == 1


def test_kept_requirements_come_before_constraints():
    known = np.array([[3.0, 20.0], [1.0, 20.0], [1.5, 20.0]])
    found = archive(np.array([[0.0], [9.0], [4.0]]), known, (BOUND, RATE), [False, True, True])
    least, why = nothing_feasible(found, (BOUND, RATE))
    assert least == 2
    assert why == []


def test_every_requirement_is_told_with_how_close_the_search_came():
    known = np.array([[9.0, 12.0], [4.0, 3.0], [2.0, 6.0]])
    found = archive(np.zeros((3, 1)), known, (BOUND, RATE), [True, False, True])
    least, (why,) = nothing_feasible(found, (BOUND, RATE))
    # Broken by 3.5 + 0, 1 + 0.7 and 0 + 0.4 limits.
    assert least == 2
    assert "so none could be offered: bound at most 2 rad was kept by 1 of 3 candidates, closest 2 rad; " in why
    assert "rate at least 10 was kept by 1 of 3 candidates, closest 12." in why


@pytest.mark.parametrize(
    ("flown", "said"), [([True, False], "none but the default was flown"), ([True] * 2, "could be offered")]
)
def test_whether_anything_was_flown_is_said(flown, said):
    known = np.array([[5.0], [4.0]])
    assert said in nothing_feasible(archive(np.zeros((2, 1)), known, (BOUND,), flown), (BOUND,))[1][0]
