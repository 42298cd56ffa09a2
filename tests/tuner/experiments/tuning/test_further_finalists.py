"""Further finalists: by what the first ones showed of a limit, on made-up evaluations."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from tests.tuner.experiments.tuning.test_active_limits import ERROR, OVERSHOOT, TRAVEL, evaluated
from tuner.experiments.tuning.further_finalists import (
    MIN_FURTHER_AT_ENDS,
    N_FURTHER_FINALISTS,
    N_FURTHER_ON_FRONT,
    further_finalists,
    thinned,
)
from tuner.experiments.tuning.validation import Validated

COUNT = 61
ERRORS = np.linspace(1.0, 4.0, COUNT)
LIMITED = np.linspace(18.0, 12.0, COUNT)
"""Candidates that cost more the further inside the limit of 15 they are: in the search, candidate 30 is at it."""


def validation_of(candidates, tuned, harshness, keeps=True) -> Validated:
    """The validation of finalists whose held-out values of the limited quantity are greater by a harshness."""
    value = np.array([20.0, *(LIMITED[candidates] + harshness)])[:, None]
    finalists = SimpleNamespace(limits=np.stack([value, value - 0.5, value + 0.5]))
    found: Any = SimpleNamespace(finalists=finalists, tuned=tuned, keeps=keeps)
    return found


def study_of(*objectives, relevant=0.02) -> Any:
    """A study with a limit on overshoot."""
    return SimpleNamespace(
        seed=1, constraints=(OVERSHOOT,), objectives=objectives, table=SimpleNamespace(relevant=relevant)
    )


def chosen(candidates, tuned, harshness, relevant=0.02, keeps=True):
    validated = validation_of(candidates, tuned, harshness, keeps)
    return further_finalists(
        evaluated(ERRORS, LIMITED), study_of(ERROR, relevant=relevant), np.array(candidates), validated
    )


def test_whoever_keeps_the_limit_by_what_finalists_showed_and_is_better_flies_too():
    # Held-out flights are harsher by 1: candidates from 40 on keep the limit, and of the finalists 55 alone does.
    rows = chosen([28, 30, 32, 55], tuned=4, harshness=1.0)
    assert 0 < len(rows) <= N_FURTHER_FINALISTS and rows.min() == 40 and rows.max() < 55
    # The second round comes closer. Rounds end if no candidate is better by more than a relevant difference.
    assert not len(chosen([28, 30, 32, 40, 55], tuned=4, harshness=1.0))
    assert len(chosen([28, 30, 32, 44, 55], tuned=4, harshness=1.0))
    assert not len(chosen([28, 30, 32, 44, 55], tuned=4, harshness=1.0, relevant=0.1))


def test_milder_flights_open_what_the_search_had_closed():
    rows = chosen([30, 32, 34], tuned=1, harshness=-1.0)
    assert rows.min() == 20 and rows.max() < 30


def test_without_a_point_that_keeps_the_limits_everyone_inside_is_better():
    rows = chosen([28, 30, 32], tuned=2, harshness=1.0, keeps=False)
    assert rows.min() == 40 and rows.max() == COUNT - 1


def test_lucky_finalists_close_the_way_to_no_others():
    # By the median distance of 2 no better candidate keeps the limit; by the smallest one of 0.6 those from 36 on do.
    candidates = [34, 36, 38, 50, 52]
    rows = chosen(candidates, 4, np.array([2.0, 2.0, 2.0, 0.6, 0.6]))
    assert len(rows) and rows.min() >= 39 and rows.max() < 50


def of_two_objectives(candidates, errors, limited, kept, harshness=0.0, relevant=0.02) -> list[int]:
    """Further finalists of a front of all candidates; errors: held-out ones of its finalists, kept: whether these keep the limit."""
    values = np.stack([ERRORS, ERRORS[::-1]], axis=1)
    validated = validation_of(candidates, tuned=1, harshness=harshness)
    finalists: Any = validated.finalists
    finalists.evaluation = SimpleNamespace(values=np.stack([[9.0, *errors], [9.0, *values[candidates, 1]]], axis=1))
    finalists.feasible = np.array([False, *kept])
    seen = evaluated(values, limited)
    study = study_of(ERROR, TRAVEL, relevant=relevant)
    return further_finalists(seen, study, np.array(candidates), validated).tolist()


def test_candidates_that_a_worse_end_had_dominated_fly_too():
    # Candidate 1 was the best and is behind 20 now: the best of those ahead of 20 fly.
    inside, kept = np.full(COUNT, 12.0), 4 * [True]
    worse = of_two_objectives([1, 20, 40, 60], [5.0, *ERRORS[[20, 40, 60]]], inside, kept)
    assert worse == list(range(2, 2 + N_FURTHER_FINALISTS))
    assert not of_two_objectives([1, 20, 40, 60], ERRORS[[1, 20, 40, 60]], inside, kept)
    # Who is ahead by less than matters does not fly, nor does anybody beyond the limit.
    ahead = [1, 2 + MIN_FURTHER_AT_ENDS, 40, 60], [5.0, *ERRORS[[2 + MIN_FURTHER_AT_ENDS, 40, 60]]]
    assert of_two_objectives(*ahead, inside, kept) == [2, 3, 4]
    assert not of_two_objectives(*ahead, inside, kept, relevant=0.2)
    assert not of_two_objectives([1, 20, 40, 60], [5.0, *ERRORS[[20, 40, 60]]], LIMITED, kept)
    # Fewer than three are not worth judging all finalists again.
    assert not of_two_objectives([1, 4, 40, 60], [5.0, *ERRORS[[4, 40, 60]]], inside, kept)


def test_an_end_that_breaks_a_limit_gives_way_to_candidates_within():
    # The best two of the first objective break the limit, held out: of those ahead of the third the furthest inside fly.
    candidates, ladders = [0, 6, 24, 40, 60], LIMITED - 4.0 + np.where(np.arange(COUNT) % 2 == 0, 0.5, 0.0)
    rows = of_two_objectives(candidates, ERRORS[candidates], ladders, 2 * [False] + 3 * [True])
    assert len(rows) == N_FURTHER_FINALISTS and np.all(np.array(rows) % 2 == 1) and (rows[0], rows[-1]) == (1, 23)
    assert not of_two_objectives(candidates, ERRORS[candidates], ladders, 5 * [True])


def test_where_most_finalists_break_a_limit_the_front_further_inside_flies():
    # Held-out flights are harsher by 1: candidates from 40 on keep the limit.
    candidates = [28, 30, 32, 36, 60]
    rows = of_two_objectives(candidates, ERRORS[candidates], LIMITED, 4 * [False] + [True], harshness=1.0)
    assert len(rows) == N_FURTHER_ON_FRONT and rows[0] == 40 and rows[-1] == 59
    assert not of_two_objectives(candidates, ERRORS[candidates], LIMITED, 2 * [False] + 3 * [True], harshness=1.0)
    # Nobody is further inside.
    assert not of_two_objectives(candidates, ERRORS[candidates], LIMITED, 5 * [False], harshness=9.0)


def test_who_is_furthest_inside_for_a_value_goes_first():
    # Of two ladders of one value the inner one is taken, and its ends are among them.
    value = np.repeat(np.linspace(1.0, 2.0, 20), 2)
    excess = -value - np.tile([0.0, 0.5], 20)
    rows = thinned(np.arange(40), np.column_stack([value, excess]))
    assert len(rows) == N_FURTHER_FINALISTS and np.all(rows % 2 == 1) and {1, 39} <= set(rows.tolist())
    few = np.array([3, 7])
    assert thinned(few, np.zeros((2, 2))).tolist() == [3, 7]
