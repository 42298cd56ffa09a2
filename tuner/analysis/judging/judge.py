"""Judge a gains file by the hard limits of a study, on scenarios of a sealed stream that no search and no tuning has seen."""

from collections.abc import Callable
from functools import singledispatch
from math import degrees
from pathlib import Path

import numpy as np

from objectives.problem import FlightBatch, Problem
from plant.errors import InputError
from tuner.analysis.judging.rows import judged_rows, overall
from tuner.documents.judgement import JudgedRow, JudgementDocument
from tuner.gains import Controller, read_gains
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study, TuningStudy
from tuner.study.tuned_loops import read_plant_row
from tuner.text.sentences import differing

CHECK = "check"


def row_to_judge(gains: Path, study: TuningStudy) -> np.ndarray:
    """Return the gains row (g,) of a file; InputError where it is of another controller, or the study has nothing to judge by."""
    if all(entry.floor for entry in study.constraints) and not study.requirements:
        limits = "a [[guarantee]] or a [[margin]]" if isinstance(study, Study) else "or a [[margin]]"
        raise InputError(
            'nothing here limits anything; write at least one [[constraint]], for instance metric = "failure" with most = 0.01, '
            f"{limits}",
            file=study.path,
        )
    return row_for(study, gains)


@singledispatch
def row_for(study: TuningStudy, gains: Path) -> np.ndarray:
    """Return the gains row (g,) of a file whose controller is that of a study; InputError names all that differs."""
    raise TypeError(f"no gains of {study.kind} in {gains}")


@row_for.register
def _(study: Study, gains: Path) -> np.ndarray:
    controller = read_gains(gains)
    check_agreement(controller, gains, study)
    return np.array(controller.gains)


@row_for.register
def _(study: PlantStudy, gains: Path) -> np.ndarray:
    return read_plant_row(gains, study.system)


def check_batches(study: TuningStudy, seeds: int | None) -> tuple[FlightBatch, ...]:
    """Return the flights to judge by: so many of each scenario, by default as many as the study's held-out check."""
    return tuple(FlightBatch(entry.spec, CHECK, seeds or entry.held_out) for entry in study.scenarios)


def judge_gains(
    row: np.ndarray, study: TuningStudy, problem: Problem, batches: tuple[FlightBatch, ...],
    on_flights_done: Callable[[int], None] | None = None,
) -> list[JudgedRow]:  # fmt: skip
    """Fly a gains row (g,), whatever it breaks without flying, and return a row for each limit and objective."""
    evaluation = problem.evaluate_gains(row[None], batches, on_flights_done, fly_all=True, complete=True)
    return judged_rows(study, problem, row, evaluation)


def judgement_document(
    gains: Path, study: TuningStudy, rows: list[JudgedRow], batches: tuple[FlightBatch, ...]
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


def check_agreement(controller: Controller, gains: Path, study: Study) -> None:
    """Raise InputError naming all that differs between a controller and a study in airframe, laws, options and periods."""
    differing = differences(controller, study)
    if differing:
        raise InputError(
            f"what {gains} holds is not what this study flies: {'; '.join(differing)}; judge the gains by a study of their own "
            "controller, or tune them for this one",
            file=study.path, key="controller" if "airframe" not in differing[0] else "airframe",
        )  # fmt: skip


def differences(controller: Controller, study: Study) -> list[str]:
    """Return what differs, each as "NAME 'gains' instead of 'study'"; the plant step is the simulation's own."""
    system, timing = study.system, study.system.timing
    pairs: list[tuple[str, object, object]] = [
        ("airframe", controller.airframe.name, study.airframe.name),
        ("position law", controller.cascade.position.name, system.cascade.position.name),
        ("attitude law", controller.cascade.attitude.name, system.cascade.attitude.name),
        ("control_period [s]", controller.control_period, timing.control_period),
        ("tilt_limit_deg", degrees(controller.options.tilt_limit), degrees(study.options.tilt_limit)),
        *[
            (key, value, getattr(study.options, key))
            for key, value in vars(controller.options).items()
            if key != "tilt_limit"
        ],
    ]
    found = differing(pairs)
    if controller.airframe.name == study.airframe.name and controller.airframe.vehicle != study.airframe.vehicle:
        found.insert(
            0, f"airframe '{study.airframe.name}' has other numbers in the study's file than in the gains file"
        )
    return found
