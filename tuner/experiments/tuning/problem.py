"""The problem that a study poses, and the flights for it."""

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path

from objectives.engine import Engine
from objectives.margins import curve
from objectives.memory import FlightMemory
from objectives.problem import FlightBatch, Problem
from plant.errors import InputError
from plant.own_code import HAVE_RUN
from plant.python_process import HOME, python_command
from plant.quadrotor.scenarios import SEARCH
from tuner.search import bayesian_optimization, covariance
from tuner.search.names import ALGORITHMS
from tuner.search.watcher import Watcher, compilation
from tuner.study.study import SearchedStudy, TuningStudy


def batches(study: SearchedStudy, stream: str) -> tuple[FlightBatch, ...]:
    """Return the flights of a study in a stream; held-out check and confirmation take equally many."""
    return tuple(
        FlightBatch(entry.spec, stream, entry.search if stream == SEARCH else entry.held_out)
        for entry in study.scenarios
    )


def first_batches(study: SearchedStudy) -> tuple[FlightBatch, ...]:
    """Return the flights that every candidate of the search makes."""
    return tuple(replace(batch, count=study.search.flights_first(batch.count)) for batch in batches(study, SEARCH))


def remaining_batches(study: SearchedStudy) -> tuple[FlightBatch, ...]:
    """Return the flights of the search that only survivors make."""
    pairs = zip(batches(study, SEARCH), first_batches(study), strict=True)
    return tuple(replace(batch, start=first.count) for batch, first in pairs)


def problem_of(
    study: TuningStudy,
    threads: int | None,
    memory: FlightMemory | None,
    engine: Engine | None = None,
    model: str | None = None,
) -> Problem:
    """Return the problem that a study poses; model: key of the sources that made the flights in memory, by default ours."""
    return Problem(
        study.system,
        study.space,
        study.objectives,
        study.constraints,
        study.seed,
        threads,
        study.screens,
        memory,
        engine,
        model,
    )


def check_searched(study: TuningStudy) -> None:
    """Refuse a study that searches no gain."""
    if not study.space.variables:
        raise InputError(
            'no gain is searched; give at least one a range, for instance "attitude.lambda" = {}',
            file=study.path,
            key="gains",
        )


def warm_up(problem: Problem, study: TuningStudy, watcher: Watcher, folder: Path | None = None) -> None:
    """Compile flights, margins and models before anything is timed.

    It compiles once for a combination of laws. folder: of a run that is to search; the models of its search are
    compiled too, and the margins, where another process may read the study, by one.
    """
    flights = not (problem.flyer.cached and problem.engine.ready(batches(study, SEARCH)[0]))
    margins = bool(study.table.margin) and not curve.is_compiled()
    models = folder is not None and ALGORITHMS[study.search.algorithm].screens and not covariance.is_compiled()
    if not (flights or margins or models):
        return
    with compilation(watcher):
        with compiled_beside(folder) if folder is not None and margins and study.is_reread else nullcontext():
            if flights:
                problem.warm_up(study.default_row, study.scenarios[0].spec)
            if models:
                bayesian_optimization.warm_up()
        ask_margins(problem, study)


def ask_margins(problem: Problem, study: TuningStudy) -> None:
    """Compute the margins of the default, only to compile them."""
    problem.excess(study.space.point(study.default_row)[None])


@contextmanager
def compiled_beside(folder: Path) -> Iterator[None]:
    """Compile the margins of a results folder in another process.

    At the end they are compiled. Compiling holds Python's lock, so a thread would not do: for the quickstart 15 of 34 s
    are margins, on either of two cores. If the process fails, the first use of the margins compiles them.
    """
    code = (
        "from pathlib import Path; from tuner.experiments.again.resume import recorded_study; "
        "from tuner.study.own_code import use; list(map(use, sys.argv[2:])); "
        "from tuner.experiments.tuning.problem import ask_margins, problem_of; "
        "study, _ = recorded_study(Path(sys.argv[1])); ask_margins(problem_of(study, None, None), study)"
    )
    named = [str(code_run.file.resolve()) for code_run in HAVE_RUN.values()]
    with subprocess.Popen(
        python_command(code, str(folder.resolve()), *named),
        cwd=HOME,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as process:
        try:
            yield
        except BaseException:
            process.kill()
            raise
