"""Judge a gains file by the hard limits of a study.

The scenarios are of a sealed stream that no search and no tuning has seen.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from objectives.problem import FlightBatch, Problem
from plant.errors import InputError
from tuner.analysis.judged_rows import judged_rows, overall
from tuner.documents.judgement import JudgedRow, JudgementDocument
from tuner.study.tuning_study import TuningStudy

CHECK = "check"


def row_to_judge(gains: Path, study: TuningStudy) -> np.ndarray:
    """Return the gains row (g,) of a file; InputError where it is of another controller, or the study has nothing to judge by."""
    if all(entry.floor for entry in study.constraints) and not study.requirements:
        raise InputError(
            'nothing here limits anything; write at least one [[constraint]], for instance metric = "failure" with most = 0.01, '
            f"{study.limit_tables}",
            file=study.path,
        )
    return study.read_row(gains)


def check_batches(study: TuningStudy, seeds: int | None) -> tuple[FlightBatch, ...]:
    """Return the flights to judge by: so many of each scenario, by default as many as the study's held-out check."""
    return tuple(FlightBatch(entry.spec, CHECK, seeds or entry.held_out) for entry in study.scenarios)


def judge_gains(
    row: np.ndarray,
    study: TuningStudy,
    problem: Problem,
    batches: tuple[FlightBatch, ...],
    on_flights_done: Callable[[int], None] | None = None,
) -> list[JudgedRow]:
    """Fly a gains row (g,) and judge each limit and objective.

    It flies even where the gains break requirements that need no flight.
    """
    evaluation = problem.evaluate_gains(row[None], batches, on_flights_done, fly_all=True, complete=True)
    return judged_rows(study, problem, row, evaluation)


def judgement_document(
    gains: Path, study: TuningStudy, rows: list[JudgedRow], batches: tuple[FlightBatch, ...]
) -> JudgementDocument:
    """Return the whole judgement."""
    return JudgementDocument(
        verdict=overall(rows),
        gains=str(gains),
        requirements=str(study.path),
        digest=study.digest(),
        seed=study.seed,
        stream=CHECK,
        flights=sum(batch.count for batch in batches),
        rows=rows,
    )
