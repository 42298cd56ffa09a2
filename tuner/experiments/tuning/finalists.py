"""Finalists of a search: its front, thinned, and candidates on both sides of a limit that binds."""

from dataclasses import replace
from math import ceil

import numpy as np

from objectives.evaluator import Evaluation, Evaluator
from objectives.requirements import known_values, requirement_excess
from plant.ties import increasing_order
from tuner.experiments.tuning.active_limits import BackOff, beside_limits, shifted_excess
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.experiments.tuning.survivors import Survivors, picked
from tuner.search.front import feasible_front, select_subset
from tuner.search.infeasible import nothing_feasible
from tuner.search.loop import Archive
from tuner.study.searched import SearchedStudy

# Finalists of the front at most; of two objectives at least, and candidates of the search for each. Of 41 to 47 points of a front
# that 136 candidates left, the 24 that add most dominated held out 99.0 to 99.5 % of what all of them dominate; of 27 to 34 that
# 48 candidates left, 16 dominated 97.5 to 98.7 % for a tenth less of the whole run's processor time than 24 (99.3 %). Of three
# objectives 16 points dominate 93 to 96 % and 48 99 %.
MAX_FRONT_FINALISTS, MIN_FRONT_FINALISTS, CANDIDATES_PER_FINALIST = 48, 16, 6
MAX_NEAR_BEST = 15
"""Further finalists near the best candidate of one objective."""
MAX_NEAR_FRONT = 8
"""Further finalists near a front."""
MAX_CHOICES = 4
"""Choices of finalists."""
N_CHECKED = 4
"""Finalists of a choice whose limits without flights are checked in all states."""


def finalists_in_all_states(
    problem: Evaluator, survivors: Survivors, tried: Archive, study: SearchedStudy, back_off: BackOff | None = None
) -> tuple[np.ndarray, list[str]]:
    """Return `finalists_of` of which some keep known limits in all states.

    A search looks at some of the steady states. If its best all stand at a margin, all may break it in another one, by about
    as much; then those are left out that would break it too.
    """
    first = chosen = finalists_of(survivors, tried, study, back_off)
    limits = len(study.constraints)
    for _ in range(MAX_CHOICES if problem.requirements else 0):
        some = chosen[0][:: ceil(len(chosen[0]) / N_CHECKED)]
        values = known_values(problem.screens, problem.space.gains(tried.points[some]), complete=True)
        excess, rows = requirement_excess(problem.requirements, values), np.searchsorted(survivors.candidates, some)
        if np.any(np.all(excess <= 0.0, axis=1)):
            return chosen
        seen = survivors.evaluation.excess[:, limits:]
        further = np.maximum(np.median(excess - seen[rows], axis=0), 0.0)
        keeps = np.flatnonzero(np.all(seen + further <= 0.0, axis=1) & ~np.isin(np.arange(len(seen)), rows))
        if not len(keeps):
            break
        survivors = replace(
            survivors, candidates=survivors.candidates[keeps], evaluation=picked(survivors.evaluation, keeps)
        )
        chosen = finalists_of(survivors, tried, study, back_off)
    return first


def finalists_of(
    survivors: Survivors, tried: Archive, study: SearchedStudy, back_off: BackOff | None = None
) -> tuple[np.ndarray, list[str]]:
    """Return the archive indices to re-fly and what to warn of; back_off: from limits, measured by fresh flights."""
    warnings, seen = warnings_before_run(study), survivors.evaluation
    front = feasible_front(seen.values, np.maximum(shifted_excess(seen, back_off), 0.0))
    if not len(front):
        front = feasible_front(seen.values, seen.violations)
    if len(front):
        front = front[select_subset(seen.values[front], seen.values[front].max(axis=0), most_on_front(study))]
    rows = np.concatenate([front, around_limits(seen, study, front, back_off)])
    if len(rows) == 0:
        least, why = nothing_feasible(tried, study.requirements, study.constraints)
        return np.array([least]), [*warnings, *why]
    return survivors.candidates[rows[increasing_order(seen.values[rows, 0])]], warnings


def around_limits(seen: Evaluation, study: SearchedStudy, front: np.ndarray, back_off: BackOff | None) -> np.ndarray:
    """Return rows (k,) on both sides of binding limits, next to a front."""
    most, first = most_beside(study), np.array([], dtype=int)
    if back_off is not None and np.any(back_off.width > 0.0):
        # What fresh flights of some points say need not hold for others: half go by it, the others by the search's own flights.
        first = beside_limits(seen, study.constraints, front, study.seed, ceil(most / 2), back_off)
    chosen = np.concatenate([front, first])
    return np.concatenate([first, beside_limits(seen, study.constraints, chosen, study.seed, most - len(first))])


def most_on_front(study: SearchedStudy) -> int:
    """Return the maximum number of finalists of the front: a longer search has a longer front."""
    if len(study.objectives) > 2:
        return MAX_FRONT_FINALISTS
    return min(max(study.search.candidates // CANDIDATES_PER_FINALIST, MIN_FRONT_FINALISTS), MAX_FRONT_FINALISTS)


def most_beside(study: SearchedStudy) -> int:
    """Return the maximum number of finalists next to the front."""
    return MAX_NEAR_BEST if len(study.objectives) == 1 else MAX_NEAR_FRONT


def most_finalists(study: SearchedStudy) -> int:
    """Return the maximum number of finalists besides the default."""
    return (1 if len(study.objectives) == 1 else most_on_front(study)) + most_beside(study)
