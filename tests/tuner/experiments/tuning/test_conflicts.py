"""What stands in the way where nothing is feasible, and what limits cost where something is: against brute force and by hand."""

from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest

from objectives.metrics import parse
from objectives.problem import Constraint, Objective
from objectives.requirements import Requirement, requirement_excess
from objectives.risk import Risk
from tuner.experiments.tuning.conflicts import (
    MAX_SETS,
    conflict_of,
    conflict_texts,
    conflicting_sets,
    cost_texts,
    costs_of,
    limits_of,
    shares,
)
from tuner.experiments.tuning.next_commands import rejudge_command, upper_end_of
from tuner.search.loop import Archive

SATURATION = Constraint(Objective(parse("saturation"), Risk("mean")), 0.02)
FAILURE = Constraint(Objective(parse("failure"), Risk("mean")), 0.0)
PHASE = Requirement("phase_margin", "a margin", "deg", 35.0, "min")
PEAK = Requirement("ms", "a peak", "1", 2.0, "max", hard=False)
CONSTRAINTS, REQUIREMENTS = (SATURATION, FAILURE), (PHASE, PEAK)
LIMITS = limits_of(CONSTRAINTS, REQUIREMENTS)


def archive(rows, values=None, flown=None):
    """An archive of rows (saturation, failure, phase margin, ms)."""
    table = np.array(rows, dtype=float)
    broken = np.maximum(table[:, :2] - [0.02, 0.0], 0.0)
    violations = np.concatenate([broken, np.maximum(requirement_excess(REQUIREMENTS, table[:, 2:]), 0.0)], axis=1)
    n = len(table)
    flown = np.ones(n, dtype=bool) if flown is None else np.array(flown)
    values = np.zeros((n, 2)) if values is None else np.array(values, dtype=float)
    return Archive(np.zeros((n, 1)), values, violations, table[:, 2:], flown)


def brute_force(kept):
    """All minimum-cardinality sets, by looking at every subset and every row."""
    every = [
        some
        for size in range(1, kept.shape[1] + 1)
        for some in combinations(range(kept.shape[1]), size)
        if not any(all(row[i] for i in some) for row in kept)
    ]
    return [some for some in every if len(some) == len(every[0])] if every else []


def conflicting(found, limits):
    """Return the conflict of an archive that has one."""
    conflict = conflict_of(found, limits)
    assert conflict is not None
    return conflict


@pytest.mark.parametrize("seed", range(12))
def test_smallest_sets_against_brute_force(seed):
    kept = np.random.default_rng(seed).random((9, 5)) < 0.35 + 0.04 * seed
    assert conflicting_sets(kept) == brute_force(kept)[:MAX_SETS]


def test_pairs_conflict_where_each_is_kept_by_somebody():
    kept = np.array([[True, True, False], [True, False, True], [False, True, True]])
    assert conflicting_sets(kept) == [(0, 1, 2)]
    assert conflicting_sets(kept[:2]) == [(1, 2)]


def test_nothing_to_say_where_somebody_keeps_all():
    assert conflict_of(archive([[0.01, 0.0, 40.0, 1.5], [0.5, 0.0, 40.0, 1.5]]), LIMITS) is None
    none = np.zeros((3, 0))
    assert conflict_of(Archive(np.zeros((3, 1)), np.zeros((3, 2)), none, none, np.ones(3, dtype=bool)), []) is None


def test_conflict_and_both_relaxations_by_hand():
    found = archive(
        [
            [0.030, 0.0, 36.0, 1.9],  # saturation too high by 50 %
            [0.010, 0.0, 31.2, 1.9],  # phase margin too low by 3.8/35 = 10.9 %
            [0.010, 0.0, 28.0, 1.9],  # the same by 20 %
            [0.021, 0.0, 33.6, 1.9],  # 5 % and 4 %: the least in common
            [0.010, 0.0, 40.0, 9.0],  # ms too high by 350 %
        ]
    )
    conflict = conflicting(found, LIMITS)
    assert conflict is not None
    # Phase and saturation are kept together by the last, as is each pair: only all three conflict.
    assert conflict.sets == ((0, 2, 3),)
    assert [(entry.candidate, [i for i, _ in entry.changes]) for entry in conflict.single] == [
        (0, [0]),
        (1, [2]),
        (4, [3]),
    ]
    assert [entry.changes[0][1] for entry in conflict.single] == pytest.approx([0.03, 31.2, 9.0])
    assert conflict.common is not None and conflict.common.candidate == 3
    assert conflict.common.share == pytest.approx(0.05)
    assert dict(conflict.common.changes) == pytest.approx({0: 0.021, 2: 33.6})
    told = conflict_texts(conflict, LIMITS)
    assert told[0] == (
        "Kept together by none of them: mean(saturation) at most 0.02 and phase_margin at least 35 deg and ms at most 2."
    )
    assert "phase_margin 35 deg -> 31.2 deg alone would let p0001 in." in told
    assert not any("p0003" in text for text in told), "one limit alone is enough"


def test_limits_that_only_give_way_together_are_told_in_plain_words_unless_they_let_only_the_default_in():
    found = archive([[0.021, 0.0, 33.6, 1.9], [0.09, 0.0, 31.2, 1.9]])
    conflict = conflicting(found, LIMITS)
    told = "All of these together would let p0000 in: mean(saturation) 0.02 -> 0.021, phase_margin 35 deg -> 33.6 deg."
    assert conflict.single == () and conflict_texts(conflict, LIMITS)[-1] == told
    assert not any("p0000" in text for text in conflict_texts(conflict, LIMITS, default=0))


def test_a_relaxed_constraint_holds_at_the_upper_end_of_its_interval_and_the_command_says_so():
    found = archive([[0.030, 0.0, 36.0, 1.9], [0.010, 0.0, 31.2, 1.9]])
    conflict = conflict_of(found, LIMITS, lambda candidate, i: {(0, 0): 0.0361234}[candidate, i])
    assert conflict is not None and conflict.single[0].share == pytest.approx(0.0161234 / 0.02)
    told = conflict_texts(conflict, LIMITS, command=lambda key, value: f"judge {key}={value}")
    (saturation,) = [text for text in told if "p0000" in text]
    assert saturation == (
        "mean(saturation) 0.02 -> 0.03613 alone would let p0000 in: `judge constraint.0.max=0.03613`."
    )
    assert "phase_margin 35 deg -> 31.2 deg alone would let p0001 in." in told


def test_the_upper_end_of_a_constraint_is_what_satisfies_it_at_its_confidence():
    samples = np.random.default_rng(3).normal(5.0, 1.0, size=64)
    constraint = Constraint(Objective(parse("travel"), Risk("mean")), 0.02, confidence=0.95)
    high = upper_end_of(constraint, samples, 1)
    assert samples.mean() + 1.5 * samples.std() / 8.0 < high < samples.mean() + 4.0 * samples.std() / 8.0
    assert upper_end_of(replace(constraint, confidence=0.0), samples, 1) == samples.mean()
    # A share of lost flights rests on its value at a limit of 0 alone: any other limit is held by the interval.
    lost = np.array([1.0] + [0.0] * 63)
    assert upper_end_of(Constraint(Objective(parse("failure"), Risk("mean")), 0.0, confidence=0.95), lost, 1) > 0.05


def test_the_code_of_a_study_is_named_by_the_command():
    content = {"plant": {"file": "../tanks.py"}, "metric": {"file": ["a.py", "b/c.py"]}, "airframe": {"file": "x.toml"}}
    study = SimpleNamespace(content=content)
    code = " ".join(f"--code FOLDER/inputs/{name}" for name in ("a.py", "c.py", "tanks.py"))
    assert rejudge_command(study, "constraint.1.max", "360") == (  # pyright: ignore[reportArgumentType]
        f"tuner rejudge FOLDER {code} --set constraint.1.max=360 --out NEW"
    )


def test_a_relaxed_limit_as_written_lets_the_candidate_in():
    found = archive([[0.010, 0.0, 31.23456, 1.9], [0.0212345, 0.0, 40.0, 1.9]])
    told = " ".join(conflict_texts(conflicting(found, LIMITS), LIMITS))
    assert "35 deg -> 31.23 deg" in told and "0.02 -> 0.02124" in told


def test_a_limit_of_zero_gives_way_in_its_own_unit():
    conflict = conflicting(archive([[0.01, 0.25, 40.0, 1.5], [0.01, 0.125, 40.0, 1.5]]), LIMITS)
    assert conflict.sets == ((1,),)
    common = conflict.common
    assert common is not None and common.changes == ((1, 0.125),) and common.candidate == 1
    assert conflict_texts(conflict, LIMITS) == ["mean(failure) 0 -> 0.125 alone would let p0001 in."]


def test_the_default_is_no_find_of_the_search():
    conflict = conflicting(archive([(0.09, 0.0, 36.0, 1.0), (0.0, 1.0, 3.0, 9.0)]), LIMITS)
    assert conflict_texts(conflict, LIMITS, default=0)[-1].endswith("would let p0000, the default itself, in.")
    assert conflict_texts(conflict, LIMITS, default=1)[-1].endswith("would let p0000 in.")


def test_of_candidates_that_did_not_fly_only_requirements_are_known():
    # The second would be the smallest step of the phase margin, but nobody knows whether it saturates.
    found = archive([[0.01, 0.0, 30.0, 1.5], [0.0, 0.0, 34.0, 1.5]], flown=[True, False])
    assert np.isinf(shares(found, LIMITS)[1, :2]).all() and np.isfinite(shares(found, LIMITS)[1, 2:]).all()
    conflict = conflicting(found, LIMITS)
    assert conflict.sets == ((2,),) and [entry.candidate for entry in conflict.single] == [0]


def test_no_finite_step_is_said():
    conflict = conflicting(archive([[0.01, 0.0, 40.0, np.inf]]), LIMITS)
    assert conflict.common is None and conflict.single == ()
    assert "widen the ranges" in conflict_texts(conflict, LIMITS)[-1]


def test_what_a_limit_costs_by_hand():
    rows = [
        [0.010, 0.0, 40.0, 1.5],  # feasible
        [0.010, 0.0, 40.0, 1.5],  # feasible
        [0.050, 0.0, 40.0, 1.5],  # only saturation in its way
        [0.050, 0.0, 40.0, 5.0],  # two limits: nobody's cost
        [0.010, 0.0, 20.0, 1.5],  # phase in its way, flown (the default)
        [0.010, 0.0, 20.0, 1.5],  # the same, but not flown
    ]
    values = [[0.31, 5.0], [0.40, 3.0], [0.28, 9.0], [0.01, 0.1], [0.5, 2.0], [0.0, 0.0]]
    found = archive(rows, values, [True] * 5 + [False])
    costs = costs_of(found, LIMITS)
    assert [tuple(cost) for cost in costs] == [(0, 0, 0.31, 0.28), (2, 1, 3.0, 2.0)]
    told = cost_texts(costs, LIMITS, ["cvar80(itae.position)", "mean(travel)"], ["m", "1/s"])
    assert told[0] == (
        "Without mean(saturation) at most 0.02 the front of the search reaches 0.28 m instead of 0.31 m in "
        "cvar80(itae.position)."
    )
    assert len(told) == 2


def test_nothing_feasible_costs_nothing():
    assert costs_of(archive([[0.5, 0.0, 40.0, 1.5]], [[1.0, 1.0]]), LIMITS) == []
