"""Conclusion of a search on flights that it never saw: finalists, the recommended point, warnings."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import cast

import numpy as np

from objectives.problem import Evaluator, Problem
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT
from plant.ties import first_smallest, increasing_order
from tuner.analysis.finals import Finals
from tuner.analysis.held_out import Finalists, SearchEstimate, compare, compare_known, judge
from tuner.analysis.lost_flights import loss_costs
from tuner.analysis.plant_step import estimated_plant_step, plant_step_warnings
from tuner.documents.summary import ComparedRow
from tuner.documents.verdicts import NOT_CERTAIN
from tuner.experiments.tails.limits import FinalistTails, TailLimits
from tuner.experiments.tuning.conflicts import (
    conflict_of,
    conflict_texts,
    cost_texts,
    costs_of,
    limits_of,
)
from tuner.experiments.tuning.ending import obstacles_of
from tuner.experiments.tuning.flight_growth import grown_study
from tuner.experiments.tuning.guards import warnings_after_run, warnings_before_run
from tuner.experiments.tuning.next_commands import rejudge_command, upper_ends
from tuner.experiments.tuning.outcome import Outcome, P, S, finalist_gains
from tuner.experiments.tuning.problem import batches
from tuner.experiments.tuning.survivors import Survivors, survivors_of
from tuner.report.tail_words import tail_words
from tuner.search.front import non_dominated, pick, select_subset
from tuner.search.infeasible import nothing_feasible
from tuner.search.loop import Archive, Generation, archive, point_name
from tuner.search.watcher import CHECKING, Watcher
from tuner.study.searched import SearchedStudy
from tuner.study.tuning_study import TuningStudy
from tuner.text.numbers import significant
from tuner.text.sentences import limit_text

# Finalists re-flown at most; of two objectives at least, and candidates of the search for each. Of 41 to 47 points of a front
# that 136 candidates left, the 24 that add most dominated held out 99.0 to 99.5 % of what all of them dominate; of 27 to 34 that
# 48 candidates left, 16 dominated 97.5 to 98.7 % for a tenth less of the whole run's processor time than 24 (99.3 %). Of three
# objectives 16 points dominate 93 to 96 % and 48 99 %.
MOST_FINALISTS, OF_TWO, TRIED = 48, 16, 6


def conclude(
    problem: P, study: S, generations: list[Generation], watcher: Watcher, begin: float, first_warnings: list[str]
) -> Outcome[S, P]:
    """Fly default and front on held-out scenarios and pick the recommended point; first_warnings: those so far."""
    tried = archive(generations)
    survivors = survivors_of(problem, grown_study(study, generations), generations, watcher)
    candidates, warnings = finalists_of(survivors, tried, study)
    flown, confirming = batches(study, HELD_OUT), batches(study, CONFIRMATION)
    gains = finalist_gains(problem, study, tried, candidates)
    watcher.on_stage(CHECKING, (len(gains) + 2) * sum(batch.count for batch in flown))
    finals = Finals(problem, gains, flown, partial(best_row, study), study.seed, watcher.on_flights_done)
    names = ["default", *[point_name(int(candidate)) for candidate in candidates]]
    tails = tails_of(problem, study, gains, watcher)
    finalists, tuned, why = judged(study, finals, survivors.seen([0, *candidates.tolist()]), names, tails)
    confirmation = problem.evaluate_gains(
        gains[[0, tuned]], confirming, watcher.on_flights_done, fly_all=True, complete=True
    )
    costs = loss_costs(problem, confirming) if isinstance(problem, Problem) else None
    table = compare(problem, confirmation, study.seed, study.table.relevant, costs)
    if tails is not None:
        table = tails.rows(table, tuned, confirmation)
    warnings += uncertain_limits(table)
    limits, fully_flown = limits_of(study.constraints, study.requirements), completely_known(tried, generations)
    conflict = conflict_of(fully_flown, limits, upper_ends(problem, study, generations))
    if conflict is not None:
        warnings += conflict_texts(conflict, limits, default_candidate(tried, study), partial(rejudge_command, study))
    plant_step = None
    # Who makes flights here has a study of a system.
    if isinstance(problem, Problem):
        plant_step = estimated_plant_step(problem, cast(TuningStudy, study), gains[[0, tuned]])
        warnings += plant_step_warnings(plant_step, study.plant_step_key)
    outcome = Outcome(
        study,
        problem,
        generations,
        survivors,
        candidates,
        finalists,
        confirmation,
        tuned,
        why,
        table,
        compare_known(problem, gains[[0, tuned]]),
        conflict,
        obstacles_of(problem, study, generations, tried, conflict, limits),
        costs_of(fully_flown, limits),
        plant_step,
        [*first_warnings, *warnings],
        0.0,
    )
    warnings = [*outcome.warnings, *warnings_after_run(outcome)]
    return replace(outcome, warnings=warnings, seconds=perf_counter() - begin)


def tails_of(problem: Evaluator, study: SearchedStudy, gains: np.ndarray, watcher: Watcher) -> FinalistTails | None:
    """Return the finalists' limits on rare events, None without any; gains (rows, g)."""
    if not isinstance(problem, Problem) or not any(entry.is_tail for entry in study.constraints):
        return None
    return FinalistTails(TailLimits(cast(TuningStudy, study), problem.flyer.threads, watcher), gains)


def judged(
    study: SearchedStudy,
    finals: Finals,
    before: list[SearchEstimate],
    names: Sequence[str],
    tails: FinalistTails | None = None,
) -> tuple[Finalists, int, str]:
    """Fly the finalists; return them with row and reason of the recommended one, which makes all flights."""
    flown = finals.fly()
    while True:
        finalists = judge(flown, before, 0.0 if tails is None else tails.excess)
        tuned, why = recommend(study, finalists, names)
        rows = np.flatnonzero(~flown.complete & unsettled(finalists, tuned))
        if len(rows):
            flown = finals.complete(flown, rows)
        elif tails is None or not finalists.feasible[tuned] or not tails.judge(tuned):
            return finalists, tuned, why


def unsettled(finalists: Finalists, tuned: int) -> np.ndarray:
    """Return a mask (rows,) of those that need all flights: the recommended one, and those short of confidence alone."""
    lacking = ~finalists.feasible & np.all(finalists.evaluation.violations <= 0.0, axis=1)
    return lacking | (np.arange(len(lacking)) == tuned)


def uncertain_limits(table: list[ComparedRow]) -> list[str]:
    """Warn of limits that the point's values alone keep on confirmation flights."""
    return [
        f"{row.label} is {significant(row.tuned.value)} [{significant(row.tuned.low)}, {significant(row.tuned.high)}] on the "
        f"confirmation flights: its value keeps {limit_text(float(row.limit or 0.0), row.unit)}, its interval reaches beyond. "
        "More held_out flights narrow it; `tuner rejudge` with a smaller max picks a point further from the limit."
        for row in table
        if row.verdict == NOT_CERTAIN and row.tail_flights is None
    ]


def completely_known(tried: Archive, generations: list[Generation]) -> Archive:
    """Return an archive in which only complete candidates count as flown: through all scenarios, not ended by a race."""
    return replace(tried, flown=np.concatenate([entry.evaluation.complete for entry in generations], axis=0))


def default_candidate(tried: Archive, study: SearchedStudy) -> int | None:
    """Return the first candidate at the default, None where there is none."""
    same = np.flatnonzero(np.all(tried.points == study.space.point(study.default_row), axis=1))
    return int(same[0]) if len(same) else None


def remarks(outcome: Outcome) -> list[str]:
    """Return sentences on rare losses and the price of each limit."""
    study = outcome.study
    labels, units = zip(*[(entry.label, entry.metric.unit) for entry in study.objectives], strict=True)
    rare = tail_words(outcome.table, outcome.names[outcome.tuned])
    return [*rare, *cost_texts(outcome.costs, limits_of(study.constraints, study.requirements), labels, units)]


def finalists_of(survivors: Survivors, tried: Archive, study: SearchedStudy) -> tuple[np.ndarray, list[str]]:
    """Return the archive indices to re-fly and what to warn of."""
    warnings = warnings_before_run(study)
    if len(tried.front()) == 0:
        least, why = nothing_feasible(tried, study.requirements)
        return np.array([least]), [*warnings, *why]
    rows, values = survivors.finalists(), survivors.evaluation.values
    chosen_rows = rows[select_subset(values[rows], values[rows].max(axis=0), most_finalists(study))]
    return survivors.candidates[chosen_rows[increasing_order(values[chosen_rows, 0])]], warnings


def most_finalists(study: SearchedStudy) -> int:
    """Return the maximum number of finalists besides the default: a longer search has a longer front."""
    if len(study.objectives) > 2:
        return MOST_FINALISTS
    return min(max(study.search.candidates // TRIED, OF_TWO), MOST_FINALISTS)


def recommend(study: SearchedStudy, finalists: Finalists, names: Sequence[str]) -> tuple[int, str]:
    """Return the row of the recommended finalist and why: the pick rule, among those that beat the default everywhere."""
    values = finalists.evaluation.values
    rows = np.flatnonzero(finalists.non_dominated)
    if len(rows) == 0:
        least = first_smallest(finalists.excess[1:].sum(axis=1)) + 1
        return least, "no finalist satisfies every constraint on the held-out scenarios; this one violates them least"
    row, why = picked(study, values, rows)
    among = better_rows(values, rows)
    pair = among if len(among) == 2 else rows
    if len(pair) == 2:
        (other,) = pair[pair != row].tolist()
        why = f"{why}; the other point is {names[other]}"
    return row, why


def better_rows(values: np.ndarray, front: np.ndarray) -> np.ndarray:
    """Return the rows of a front that beat the default everywhere; none does: all.

    values (rows, objectives): of all, the default first.
    """
    beating = front[np.all(values[front] < values[0], axis=1)]
    return beating if len(beating) else front


def picked(study: SearchedStudy, values: np.ndarray, front: np.ndarray) -> tuple[int, str]:
    """Return the pick rule's row of a front, and why; values (rows, objectives): of all, the default first."""
    among = better_rows(values, front)
    chosen, why = pick(study.pick, values[among], [objective.label for objective in study.objectives])
    row = int(among[chosen])
    if not np.all(values[row] < values[0]):
        return row, f"{why}, though no point is better on held-out flights than the default in every objective"
    if len(among) == 1:
        return row, "the only point that is better on held-out flights than the default in every objective"
    return row, f"{why}, among points better on held-out flights than the default in every objective"


def best_row(study: SearchedStudy, values: np.ndarray, feasible: np.ndarray) -> int:
    """Return the row to recommend, 0 for none; values (rows, objectives), feasible (rows,): of all, the default first."""
    rows = 1 + np.flatnonzero(feasible[1:])
    return picked(study, values, rows[non_dominated(values[rows])])[0] if len(rows) else 0
