"""Judge a gains file by the hard limits of a study, on scenarios of a sealed stream that no search and no tuning has seen."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from objectives.problem import FlightBatch, Problem
from plant.errors import InputError
from tuner.analysis.judging.agreement import check_agreement
from tuner.analysis.judging.rows import judged_rows, overall
from tuner.documents.judgement import JudgedRow, JudgementDocument
from tuner.gains import Controller, read_gains
from tuner.study.study import Study

CHECK = "check"


def controller_to_judge(gains: Path, study: Study) -> Controller:
    """Read a gains file; InputError where it is none, the study is about something else or has nothing to judge by."""
    if all(entry.floor for entry in study.constraints) and not study.requirements:
        raise InputError(
            'nothing here limits anything; write at least one [[constraint]], for instance metric = "failure" with most = 0.01, '
            "a [[guarantee]] or a [[margin]]",
            file=study.path,
        )
    controller = read_gains(gains)
    check_agreement(controller, gains, study)
    return controller


def check_batches(study: Study, seeds: int | None) -> tuple[FlightBatch, ...]:
    """Return the flights to judge by: so many of each scenario, by default as many as the study's held-out check."""
    return tuple(FlightBatch(entry.spec, CHECK, seeds or entry.held_out) for entry in study.scenarios)


def judge_gains(
    controller: Controller, study: Study, problem: Problem, batches: tuple[FlightBatch, ...],
    on_flights_done: Callable[[int], None] | None = None,
) -> list[JudgedRow]:  # fmt: skip
    """Fly a controller, whatever it breaks without flying, and return a row for each limit and objective."""
    evaluation = problem.evaluate_gains(np.array([controller.gains]), batches, on_flights_done, fly_all=True)
    return judged_rows(study, problem, evaluation)


def judgement_document(
    gains: Path, study: Study, rows: list[JudgedRow], batches: tuple[FlightBatch, ...]
) -> JudgementDocument:  # fmt: skip
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
