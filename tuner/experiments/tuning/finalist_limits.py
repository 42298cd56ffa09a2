"""Limits on rare events: flights of a study cannot show them, so an extension estimates them for finalists."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, cast

import numpy as np

from objectives.problem import Evaluation, Evaluator, Problem
from tuner.documents.plan import PlannedTail
from tuner.documents.summary import ComparedRow
from tuner.extension import added, load
from tuner.search.watcher import Watcher
from tuner.study.searched import SearchedStudy
from tuner.study.study import TuningStudy


class FinalistLimits(Protocol):
    """Finalists judged by limits on rare events, one after the other."""

    @property
    def excess(self) -> np.ndarray:
        """Excess (rows, constraints) over the limits, 0 where nothing is known."""
        ...

    def judge(self, row: int) -> bool:
        """Return True if this call estimated the probabilities of a row."""
        ...

    def rows(self, table: Sequence[ComparedRow], row: int, confirmation: Evaluation) -> list[ComparedRow]:
        """Return a table with the estimates of a row.

        They stand in place of shares of its flights.
        """
        ...


@dataclass(frozen=True)
class FinalistEstimator:
    """The estimator of an extension, which its record names.

    Attributes:
        limits: Limits of finalists, from study, gains (rows, g), threads and watcher.
        words: Sentences on the estimates of a table, with the name of its tuned point.
        planned: Estimates that a study asks for, with the flights per second in its scenarios by name.
    """

    limits: Callable[[TuningStudy, np.ndarray, int | None, Watcher], FinalistLimits]
    words: Callable[[Sequence[ComparedRow], str], list[str]]
    planned: Callable[[TuningStudy, Mapping[str, float]], list[PlannedTail]]


def has_rare_limits(study: SearchedStudy) -> bool:
    """Return True for a study with limits on rare events."""
    return any(entry.is_tail for entry in study.constraints)


def estimator() -> FinalistEstimator:
    """Return the estimator; a study with such limits is refused where none is installed."""
    return load(next(iter(added("finalists").values())))


def finalist_limits(
    problem: Evaluator, study: SearchedStudy, gains: np.ndarray, watcher: Watcher
) -> FinalistLimits | None:
    """Return the finalists' limits on rare events, None without any; gains (rows, g)."""
    if not isinstance(problem, Problem) or not has_rare_limits(study):
        return None
    return estimator().limits(cast(TuningStudy, study), gains, problem.flyer.threads, watcher)


def rare_words(table: Sequence[ComparedRow], point: str) -> list[str]:
    """Return sentences on the estimates in a table, none without an estimator; point: name of the tuned one."""
    has_rows = any(row.tail_flights is not None for row in table)
    return estimator().words(table, point) if has_rows and added("finalists") else []
