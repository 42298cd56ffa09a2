"""The problem that a study poses and the flights it is posed on."""

from dataclasses import replace

from objectives.engine import Engine
from objectives.margins.curve import is_compiled
from objectives.memory import FlightMemory
from objectives.problem import FlightBatch, Problem
from plant.errors import InputError
from plant.scenarios import SEARCH
from tuner.search.watcher import Watcher, compilation
from tuner.study.study import Study


def batches(study: Study, stream: str) -> tuple[FlightBatch, ...]:
    """Return the flights of a study in a stream; held-out check and confirmation take equally many."""
    return tuple(
        FlightBatch(entry.spec, stream, entry.search if stream == SEARCH else entry.held_out)
        for entry in study.scenarios
    )


def first_batches(study: Study) -> tuple[FlightBatch, ...]:
    """Return the flights that every candidate of the search makes."""
    return tuple(replace(batch, count=study.search.flights_first(batch.count)) for batch in batches(study, SEARCH))


def remaining_batches(study: Study) -> tuple[FlightBatch, ...]:
    """Return the flights of the search that only survivors make."""
    pairs = zip(batches(study, SEARCH), first_batches(study), strict=True)
    return tuple(replace(batch, start=first.count) for batch, first in pairs)


def problem_of(
    study: Study,
    threads: int | None,
    memory: FlightMemory | None,
    engine: Engine | None = None,
    model: str | None = None,
) -> Problem:
    """Return the problem that a study poses; model: key of the sources that made the flights in memory, by default ours."""
    return Problem(
        study.system, study.space, study.objectives, study.constraints, study.seed, threads, study.screens, memory,
        engine, model,
    )  # fmt: skip


def check_searched(study: Study) -> None:
    """Refuse a study that searches no gain."""
    if not study.space.variables:
        raise InputError(
            'no gain is searched; give at least one a range, for instance "attitude.lambda" = {}',
            file=study.path, key="gains",
        )  # fmt: skip


def warm_up(problem: Problem, study: Study, watcher: Watcher) -> None:
    """Have the kernel compiled (once for a combination of laws) before anything is timed."""
    ready = problem.flyer.cached and problem.engine.ready(batches(study, SEARCH)[0])
    if ready and (not study.table.margin or is_compiled()):
        return
    with compilation(watcher):
        problem.warm_up(study.default_row, study.scenarios[0].spec)
