"""Conclusion of a search: its finalists, their validation on flights that it never saw, warnings."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import cast

import numpy as np

from objectives.evaluator import Constraint, concatenate_evaluations
from objectives.problem import Evaluator, Problem
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT
from plant.ties import increasing_order
from tuner.analysis.held_out import compare, compare_known
from tuner.analysis.lost_flights import loss_costs
from tuner.analysis.plant_step import estimated_plant_step, plant_step_warnings
from tuner.documents.summary import ComparedRow
from tuner.documents.verdicts import BROKEN, NOT_CERTAIN
from tuner.experiments.tuning.conflicts import (
    conflict_of,
    conflict_texts,
    cost_texts,
    costs_of,
    limits_of,
)
from tuner.experiments.tuning.ending import obstacles_of
from tuner.experiments.tuning.finalist_limits import FinalistLimits, finalist_limits, rare_words
from tuner.experiments.tuning.finalists import finalists_in_all_states
from tuner.experiments.tuning.flight_growth import grown_study
from tuner.experiments.tuning.further_finalists import MAX_FRONT_ROUNDS, MAX_ROUNDS, further_finalists
from tuner.experiments.tuning.guards import warnings_after_run
from tuner.experiments.tuning.limit_watch import LimitWatch
from tuner.experiments.tuning.next_commands import rejudge_command, upper_ends
from tuner.experiments.tuning.outcome import Outcome, P, S, finalist_gains
from tuner.experiments.tuning.problem import batches
from tuner.experiments.tuning.recommendation import worst_objectives
from tuner.experiments.tuning.survivors import Survivors, flown_through, survivors_of
from tuner.experiments.tuning.validation import Validated, Validation
from tuner.search.loop import Archive, Generation, archive, point_name
from tuner.search.watcher import CHECKING, Watcher
from tuner.study.searched import SearchedStudy
from tuner.study.tuning_study import TuningStudy
from tuner.text.numbers import significant
from tuner.text.sentences import counted, limit_text


def conclude(
    problem: P, study: S, generations: list[Generation], watcher: Watcher, begin: float, first_warnings: list[str]
) -> Outcome[S, P]:
    """Fly default and front on held-out scenarios and pick the recommended point; first_warnings: those so far."""
    tried = archive(generations)
    survivors, candidates, warnings = selected(problem, study, generations, tried, watcher)
    watcher.on_stage(CHECKING, (len(candidates) + 3) * sum(batch.count for batch in batches(study, HELD_OUT)))
    survivors, candidates, validated, tails = validate(
        problem, study, generations, tried, survivors, candidates, watcher
    )
    gains = finalist_gains(problem, study, tried, candidates)
    costs = loss_costs(problem, batches(study, CONFIRMATION)) if isinstance(problem, Problem) else None
    table = compare(problem, validated.confirmation, study.seed, study.table.relevant, costs)
    if tails is not None:
        table = tails.rows(table, validated.tuned, validated.confirmation)
    if validated.keeps:
        table = with_limits_by_all_flights(table, problem.constraints)
    warnings += [*validated.warnings, *uncertain_limits(table)]
    limits, fully_flown = limits_of(study.constraints, study.requirements), completely_known(tried, generations)
    conflict = None if validated.keeps else conflict_of(fully_flown, limits, upper_ends(problem, study, generations))
    if conflict is not None:
        warnings += conflict_texts(conflict, limits, default_candidate(tried, study), partial(rejudge_command, study))
    plant_step = None
    # Who makes flights here has a study of a system.
    if isinstance(problem, Problem):
        plant_step = estimated_plant_step(problem, cast(TuningStudy, study), gains[[0, validated.tuned]])
        warnings += plant_step_warnings(plant_step, study.plant_step_key)
    outcome = Outcome(
        study,
        problem,
        generations,
        survivors,
        candidates,
        validated.finalists,
        validated.confirmation,
        validated.tuned,
        validated.why,
        table,
        compare_known(problem, gains[[0, validated.tuned]]),
        conflict,
        obstacles_of(problem, study, generations, tried, conflict, limits),
        costs_of(fully_flown, limits),
        plant_step,
        [*first_warnings, *warnings],
        0.0,
        validated.broken,
        validated.to_settle,
        validated.further_flights,
    )
    warnings = [*outcome.warnings, *warnings_after_run(outcome)]
    return replace(outcome, warnings=warnings, seconds=perf_counter() - begin)


def validate(
    problem: Evaluator,
    study: SearchedStudy,
    generations: list[Generation],
    tried: Archive,
    survivors: Survivors,
    candidates: np.ndarray,
    watcher: Watcher,
) -> tuple[Survivors, np.ndarray, Validated, FinalistLimits | None]:
    """Validate finalists and further ones, by rounds."""
    seen, grown = concatenate_evaluations([entry.evaluation for entry in generations]), grown_study(study, generations)
    worst = worst_objectives(generations[0].evaluation)
    rounds, most = 0, MAX_ROUNDS if len(study.objectives) == 1 else MAX_FRONT_ROUNDS
    while True:
        gains = finalist_gains(problem, study, tried, candidates)
        names = ["default", *[point_name(int(candidate)) for candidate in candidates]]
        tails = finalist_limits(problem, study, gains, watcher)
        estimates = survivors.seen([0, *candidates.tolist()])
        validated = Validation(problem, study, gains, names, estimates, worst, watcher, tails).conclude()
        # Trials of another program and estimates of rare events take too long to be made by the way.
        is_last = rounds == most or tails is not None or not isinstance(problem, Problem)
        further = candidates[:0] if is_last else further_finalists(seen, study, candidates, validated)
        if not len(further):
            return survivors, candidates, validated, tails
        watcher.on_message(
            f"Held-out flights of {counted(len(further), 'further candidate')}: by the finalists' flights probably better and "
            "within every limit."
        )
        if grown.search.first is not None:
            both = np.union1d(survivors.candidates, further)
            survivors = flown_through(problem, grown, seen, tried.points, both, watcher.on_flights_done)
        candidates = np.concatenate([candidates, further])
        places = np.searchsorted(survivors.candidates, candidates)
        candidates = candidates[increasing_order(survivors.evaluation.values[places, 0])]
        rounds += 1


def selected(
    problem: Evaluator, study: SearchedStudy, generations: list[Generation], tried: Archive, watcher: Watcher
) -> tuple[Survivors, np.ndarray, list[str]]:
    """Return survivors, archive indices of finalists, and warnings."""
    watch = LimitWatch(problem, study, watcher.on_flights_done)
    seen, every = concatenate_evaluations([entry.evaluation for entry in generations]), np.arange(len(tried.points))
    watch.measure(seen, tried.points, every, is_late=True)
    back_off = watch.back_off(seen, every)
    survivors = survivors_of(problem, grown_study(study, generations), generations, watcher, back_off)
    # On all flights of the search other points stand at the limit.
    watch.measure(survivors.evaluation, tried.points[survivors.candidates], survivors.candidates, is_late=True)
    back_off = watch.back_off(survivors.evaluation, survivors.candidates)
    return survivors, *finalists_in_all_states(problem, survivors, tried, study, back_off)


def with_limits_by_all_flights(table: list[ComparedRow], constraints: Sequence[Constraint]) -> list[ComparedRow]:
    """Return the table of a point that all its flights confirm.

    Held-out and confirmation flights together satisfy every limit: a value of the confirmation flights beyond one is not
    certain, for it rests on a small part of them.

    Args:
        table: Rows of the objectives, then of the constraints.
        constraints: Limits on flights of the study.
    """
    flown = {entry.objective.label for entry in constraints if entry.is_flown}
    return [
        row.model_copy(update={"verdict": NOT_CERTAIN}) if row.verdict == BROKEN and row.label in flown else row
        for row in table
    ]


def uncertain_limits(table: list[ComparedRow]) -> list[str]:
    """Warn of limits that confirmation flights alone do not decide."""
    return [uncertain_text(row) for row in table if row.verdict == NOT_CERTAIN and row.tail_flights is None]


def uncertain_text(row: ComparedRow) -> str:
    """Return the warning of a limit within an interval."""
    value, low, high = row.tuned.parts
    limit = limit_text(float(row.limit or 0.0), row.unit)
    is_beyond = value is not None and row.limit is not None and value > row.limit
    clause = (
        f"its value exceeds {limit}, and all flights of the point together keep it"
        if is_beyond
        else f"its value keeps {limit}, its interval reaches beyond"
    )
    return (
        f"{row.label} is {significant(value)} [{significant(low)}, {significant(high)}] on the confirmation flights: {clause}. "
        "More held_out flights narrow it; `tuner rejudge` with a smaller max picks a point further from the limit."
    )


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
    rare = rare_words(outcome.table, outcome.names[outcome.tuned])
    return [*rare, *cost_texts(outcome.costs, limits_of(study.constraints, study.requirements), labels, units)]
