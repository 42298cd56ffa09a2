"""The recommended point and its reason, on made-up held-out values."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tuner.experiments.tuning.recommendation import (
    Default,
    choose_finalist,
    is_among_worst,
    is_improvement,
)
from tuner.search.front import non_dominated

OBJECTIVES = [SimpleNamespace(label="error"), SimpleNamespace(label="travel")]
BETTER = "better on held-out flights than the default in every objective"


def recommended(*front, default=(10.0, 10.0), keeps=True, is_worst=False, rule="knee", excess=None) -> tuple[str, str]:
    """Return name and reason of the recommended point of a front beside a default at (10, 10)."""
    values = np.array([default, *front], dtype=float)
    study: Any = SimpleNamespace(pick=rule, objectives=OBJECTIVES[: values.shape[1]])
    names = ["default", *[f"p{i}" for i in range(1, len(values))]]
    limits = np.zeros((len(values), 1)) if excess is None else np.array(excess, dtype=float)[:, None]
    rows = np.flatnonzero((limits[:, 0] <= 0.0) & (np.arange(len(values)) > 0))
    rows = rows[non_dominated(values[rows])] if values.shape[1] == 1 else rows
    row, why = choose_finalist(study, values, Default(keeps, is_worst), rows, limits, names)
    return names[row], why


@pytest.mark.parametrize(
    ("front", "point", "why"),
    [
        ([(1, 9), (2, 3), (9, 1)], "p2", f"knee of the held-out front, among points {BETTER}"),
        (
            [(9, 1), (1, 9)],
            "p2",
            "two points have no knee, so the one with the smaller error is taken, "
            f"among points {BETTER}; the other point is p1",
        ),
        ([(1, 9), (20, 1)], "p1", f"the only point that is {BETTER}; the other point is p2"),
        ([(1, 9), (2, 11), (20, 1)], "p1", f"the only point that is {BETTER}"),
    ],
)
def test_the_reason_names_the_rule_and_what_it_rests_on(front, point, why):
    assert recommended(*front) == (point, why)


@pytest.mark.parametrize("front", [[(1, 12), (2, 11), (20, 1)], [(9.9, 9.9)], [(9.9, 10.1), (5.0, 10.3)]])
def test_a_default_that_keeps_its_limits_stays_where_nothing_is_better_by_a_relevant_share(front):
    assert recommended(*front) == ("default", Default(True, False).why_kept)
    # One that breaks a limit cannot stay.
    assert recommended(*front, keeps=False)[0] != "default"


def test_a_loss_of_less_than_a_relevant_share_is_none():
    point, why = recommended((5.0, 10.1), (1.0, 30.0), keeps=False)
    assert point == "p1" and "without losing as much in another" in why
    # A default that keeps its limits stays: run after run such steps would lead along the front.
    assert recommended((5.0, 10.1), (1.0, 30.0))[0] == "default"
    # What is better everywhere goes first.
    assert recommended((5.0, 10.1), (9.0, 9.0))[0] == "p2"


@pytest.mark.parametrize("share", [0.01, 0.019, 0.021, 0.5])
def test_what_is_relevant_holds_both_ways(share):
    default, step = np.array([3.0, 7.0]), np.array([share, 0.0])
    assert is_improvement((default * (1.0 - step))[None], default)[0] == (share > 0.02)
    assert is_improvement((default * [0.5, 1.0 + share])[None], default)[0] == (share < 0.02)
    assert not is_improvement(default[None], default)[0]


# A default that never settles, for hardly any effort, and a front from 15 to 295 s (a satellite).
SATELLITE = [(15.0, 9e-3), (17.0, 6e-3), (24.0, 2e-3), (60.0, 9e-4), (130.0, 6e-4), (268.0, 6.5e-5), (295.0, 2.3e-5)]


def test_a_poor_default_does_not_restrict_the_pick():
    idle = (295.0, 4e-4)
    assert recommended(*SATELLITE, default=idle)[0] == "p6"
    point, why = recommended(*SATELLITE, default=idle, is_worst=True)
    assert point in ("p3", "p4") and why == "knee of the held-out front"
    # Among the worst in an objective, but beaten by nothing far: it stays.
    assert recommended((100.0, 1.0), (1.0, 100.0), default=(1.0, 100.0), is_worst=True) == (
        "default",
        Default(True, False).why_kept,
    )


# A default of stiff gains: hardly any error, and a travel that shakes the amplifier (a motor).
MOTOR = [(0.63, 0.15), (0.75, 0.12), (0.9, 0.1), (1.0, 0.087), (1.09, 0.08), (1.36, 0.063), (2.0, 0.043)]


def test_points_better_in_everything_are_taken_where_the_front_has_hardly_a_better_compromise():
    point, why = recommended(*MOTOR, default=(0.95, 1.0), keeps=False, is_worst=True)
    assert point in ("p2", "p3") and why.endswith(BETTER)
    # By itself the rule would go further, to more error than the default has.
    assert recommended(*MOTOR, default=(0.1, 1.0), keeps=False, is_worst=True) == ("p4", "knee of the held-out front")


def test_who_breaks_a_limit_restricts_the_pick_to_what_is_better_everywhere_and_no_further():
    assert recommended((9.0, 9.0), (1.0, 30.0), (2.0, 12.0), keeps=False)[0] == "p1"
    assert recommended((1.0, 30.0), (2.0, 12.0), (20.0, 1.0), keeps=False) == ("p2", "knee of the held-out front")


def test_without_a_point_within_limits_the_default_is_the_answer_and_else_the_nearest():
    assert recommended((9.0, 9.0), (8.0, 8.0), excess=[0.0, 2.0, 1.0])[0] == "default"
    point, why = recommended((9.0, 9.0), (8.0, 8.0), excess=[0.0, 2.0, 1.0], keeps=False)
    assert point == "p2" and "violates them least" in why


def test_of_one_objective_the_smallest_is_taken_where_it_matters():
    assert recommended((8.0,), (7.0,), default=(10.0,)) == ("p2", "smallest error of the finalists within limits")
    assert recommended((9.9,), default=(10.0,)) == ("default", Default(True, False).why_kept)


def test_a_rule_that_names_an_objective_is_obeyed_where_nothing_is_better_everywhere():
    assert recommended((1.0, 30.0), (2.0, 20.0), rule="min:error")[0] == "p1"


def test_tuned_gains_tuned_again_stay_or_are_bettered_everywhere():
    """A point of a front as the default of another run, whose front errs by 1 %: never a move along the front."""
    draw, stays = np.random.default_rng(4), 0
    for _ in range(50):
        error = np.geomspace(1.0, 30.0, 16)
        front = np.stack([error, 30.0 / error], axis=1) * draw.uniform(1.0, 1.01, (16, 2))
        default = front[draw.integers(16)] * draw.uniform(0.99, 1.01, 2)
        kept = front[non_dominated(front)]
        point, _ = recommended(*kept, default=tuple(default), is_worst=bool(draw.integers(2)))
        stays += point == "default"
        ratio = np.ones(2) if point == "default" else kept[int(point[1:]) - 1] / default
        assert np.all(ratio <= 1.0)
    assert stays > 25


def first_generation(values, flown=True) -> Any:
    return SimpleNamespace(values=np.array(values, dtype=float), flown=np.full(len(values), flown))


def test_among_the_worst_is_who_hardly_anyone_is_behind():
    spread = [(float(i), 1.0) for i in range(20)]
    assert is_among_worst(first_generation([(19.0, 0.5), *spread]))
    assert not is_among_worst(first_generation([(10.0, 0.5), *spread]))
    assert not is_among_worst(first_generation([(10.0, 0.5)]))
