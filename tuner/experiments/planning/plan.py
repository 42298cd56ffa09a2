"""Plan a study: compile its kernel, fly a pilot, and estimate run time and precision."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

from objectives.problem import Problem
from plant.errors import InputError
from tuner.analysis.plant_step import plant_step_warnings
from tuner.documents.plan import (
    PilotPart,
    PlanDocument,
    PlannedObjective,
)
from tuner.experiments.planning.cost import disk_of, memory_of, planned_tails, seconds_of
from tuner.experiments.planning.counts import flights_of
from tuner.experiments.planning.pilot import FLIGHTS, Pilot, fly_pilot, pilot_size
from tuner.experiments.planning.precision import planned_bounds, planned_objective
from tuner.experiments.tuning.conflicts import automatic_rows
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.experiments.tuning.problem import problem_of, warm_up
from tuner.extension import added, load
from tuner.search.watcher import Watcher, default_watcher
from tuner.study.kinds import AnyStudy, study_kinds
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study, TuningStudy


def plan(study: AnyStudy, share: float, watcher: Watcher | None = None, threads: int | None = None) -> Any:
    """Return the plan of a study; share: smallest difference of interest, a share of the default's values.

    Raises InputError for a study whose trials another program makes.
    """
    further = added("plans")
    if study.kind not in PLANS and study.kind not in further:
        kind = next(kind for kind in study_kinds() if kind.name == study.kind)
        message = f"this is {kind.noun}; `tuner plan` takes a study of one controller or a contest"
        raise InputError(message, file=study.path, key=kind.table)
    planned = PLANS[study.kind] if study.kind in PLANS else load(further[study.kind])
    return planned(study, share, watcher or default_watcher(), threads)


def _plan_study(study: TuningStudy, share: float, watcher: Watcher, threads: int | None) -> PlanDocument:
    pilot, seconds = timed_pilot(study, "Pilot", watcher, threads)
    return plan_document(study, pilot, seconds, share)


PLANS: dict[str, Callable[[Any, float, Watcher, int | None], PlanDocument]] = {
    Study.kind: _plan_study,
    PlantStudy.kind: _plan_study,
}
"""Planners by the kind of study of the core; those of extensions are in their records."""


def timed_pilot(study: TuningStudy, stage: str, watcher: Watcher, threads: int | None) -> tuple[Pilot, float | None]:
    """Return a study's pilot and its compile time [s]; None where it was compiled before."""
    problem = problem_of(study, threads, None)
    seconds = _compile(problem, study, watcher)
    watcher.on_stage(stage, pilot_size(problem.flyer.threads) * FLIGHTS * len(study.scenarios))
    return fly_pilot(problem, study, watcher.on_flights_done), seconds


def _compile(problem: Problem, study: TuningStudy, watcher: Watcher) -> float | None:
    cached, begin = problem.flyer.cached, perf_counter()
    warm_up(problem, study, watcher)
    # A cached kernel is loaded by its first flight, which takes a second that is not to be timed as flying.
    problem.warm_up(study.default_row, study.scenarios[0].spec)
    return None if cached else perf_counter() - begin


def plan_document(study: TuningStudy, pilot: Pilot, compile_seconds: float | None, share: float) -> PlanDocument:
    """Return the whole plan; compile_seconds: None if the kernel was there; share: smallest difference of interest."""
    objectives = [planned_objective(study, pilot, i, share) for i in range(len(study.objectives))]
    return PlanDocument(
        title=study.title,
        study=study.path.name,
        digest=study.digest(),
        seed=study.seed,
        threads=pilot.threads,
        pilot=PilotPart(
            candidates=len(pilot.points),
            flights=pilot.flights,
            seconds=pilot.seconds,
            worth_flying_percent=100.0 * pilot.worthy_share,
        ),
        flights=flights_of(study),
        seconds=seconds_of(study, pilot, compile_seconds),
        search=" ".join([study.search.text, *study.start_texts]),
        memory_bytes=memory_of(study, pilot),
        disk_bytes_at_most=disk_of(study, pilot),
        difference_percent=100.0 * share,
        objectives=objectives,
        bounds=planned_bounds(study),
        tails=planned_tails(study, pilot),
        automatic_limits=automatic_rows(study.automatic_limits),
        plant_step=pilot.plant_step,
        warnings=warnings(study, pilot, objectives, share),
    )


def warnings(study: TuningStudy, pilot: Pilot, objectives: list[PlannedObjective], share: float) -> list[str]:
    """Return the warnings before a run."""
    texts = [*warnings_before_run(study), *plant_step_warnings(pilot.plant_step, study.plant_step_key)]
    lost = sum(int(entry.failed[0].sum(axis=0)) for entry in pilot.scenarios)
    if lost:
        texts.append(
            f"The default lost {lost} of {FLIGHTS * len(pilot.scenarios)} pilot flights; its values and widths are those of "
            "failures. Start from other gains, or make the scenarios milder."
        )
    if pilot.worthy_share == 0.0:
        design = " (`tuner design`)" if study.has_designs else ""
        texts.append(
            "None of the points looked at satisfies every hard requirement; narrow the ranges of the gains towards a "
            f"design{design}, or relax a requirement."
        )
    for entry in objectives:
        have, needed = entry.flights.held_out, entry.scenarios_needed
        if needed is not None and needed > have:
            texts.append(
                f"{entry.label}: {have} held-out scenarios do not surely tell a difference of {100.0 * share:g} %; "
                f"{needed} would."
            )
    return texts
