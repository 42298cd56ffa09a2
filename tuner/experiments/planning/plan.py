"""Plan a study: compile its kernel, fly a pilot and say what the run will take and how sure its figures will be."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

from objectives.problem import Problem
from plant.errors import InputError
from tuner.documents.plan import ContestPlanDocument, PlanDocument
from tuner.experiments.planning.contest import contest_plan
from tuner.experiments.planning.document import plan_document
from tuner.experiments.planning.pilot import FLIGHTS, Pilot, fly_pilot, pilot_size
from tuner.experiments.tuning.problem import problem_of, warm_up
from tuner.search.watcher import Watcher
from tuner.study.contest import Contest
from tuner.study.kinds import STUDY_KINDS, AnyStudy
from tuner.study.study import Study

Plan = PlanDocument | ContestPlanDocument


def plan(study: AnyStudy, share: float, watcher: Watcher | None = None, threads: int | None = None) -> Plan:
    """Return the plan of a study or contest; share: of the default's values, a difference that is to be told.

    Raises InputError for an inference, which has no plan.
    """
    planned = PLANS.get(study.kind)
    if planned is None:
        kind = next(kind for kind in STUDY_KINDS if kind.name == study.kind)
        message = f"this is {kind.noun}; `tuner plan` takes a study of one controller or a contest"
        raise InputError(message, file=study.path, key=kind.table)
    return planned(study, share, watcher or Watcher(), threads)


def _plan_study(study: Study, share: float, watcher: Watcher, threads: int | None) -> Plan:
    pilot, seconds = _fly(study, "Pilot", watcher, threads)
    return plan_document(study, pilot, seconds, share)


def _plan_contest(contest: Contest, share: float, watcher: Watcher, threads: int | None) -> Plan:
    """Fly a pilot of every contender and plan the whole."""
    flown = [_fly(entry.study, f"Pilot of {entry.name}", watcher, threads) for entry in contest.contenders]
    return contest_plan(contest, [pilot for pilot, _ in flown], [seconds for _, seconds in flown], share)


PLANS: dict[str, Callable[[Any, float, Watcher, int | None], Plan]] = {
    Study.kind: _plan_study,
    Contest.kind: _plan_contest,
}
"""Planners by the kind of study."""


def _fly(study: Study, stage: str, watcher: Watcher, threads: int | None) -> tuple[Pilot, float | None]:
    """Return the pilot of a study and the time its compilation took [s], None where it was compiled before."""
    problem = problem_of(study, threads, None)
    seconds = _compile(problem, study, watcher)
    watcher.on_stage(stage, pilot_size(problem.flyer.threads) * FLIGHTS * len(study.scenarios))
    return fly_pilot(problem, study, watcher.on_flights_done), seconds


def _compile(problem: Problem, study: Study, watcher: Watcher) -> float | None:
    cached, begin = problem.flyer.cached, perf_counter()
    warm_up(problem, study, watcher)
    # A cached kernel is loaded by its first flight, which takes a second that is not to be timed as flying.
    problem.warm_up(study.default_row, study.scenarios[0].spec)
    return None if cached else perf_counter() - begin
