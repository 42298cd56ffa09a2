"""The outcome of a tuning run, whole: its study, every candidate, the finalists and the recommended point."""

from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from objectives.problem import Evaluation, Evaluator, Problem
from tuner.analysis.held_out import Finalists
from tuner.documents.obstacles import UnmetConstraint
from tuner.documents.parts import PlantStep
from tuner.documents.summary import ComparedRow, RequiredRow
from tuner.experiments.tuning.conflicts import Conflict, LimitPrice
from tuner.experiments.tuning.survivors import Survivors
from tuner.search.loop import Archive, Generation, archive, point_name
from tuner.study.study import SearchedStudy, TuningStudy

S = TypeVar("S", bound=SearchedStudy)
P = TypeVar("P", bound=Evaluator)


@dataclass(frozen=True)
class Outcome(Generic[S, P]):
    """The findings of a run.

    Attributes:
        candidates: Archive indices of the finalists behind the default.
        tuned: Row in the finalists of the recommended point, 0 for the default, or of the one that breaks least where nothing is
            feasible.
        confirmation: The default and the recommended point on scenarios that decided nothing, for table and required_rows.
        conflict: Conflict of the limits where nothing was feasible.
        obstacles: Causes behind the conflict.
        costs: Cost of each limit where something was feasible.
        broken_again: Indices of constraints that `tuned` breaks on confirmation flights.
        to_settle: About the flights that would decide that the nearest keeps its limits, None where its values break one.
        further_flights: Number of flights made because a limit was open.
    """

    study: S
    problem: P
    generations: list[Generation]
    survivors: Survivors
    candidates: np.ndarray
    finalists: Finalists
    confirmation: Evaluation
    tuned: int
    why: str
    table: list[ComparedRow]
    required_rows: list[RequiredRow]
    conflict: Conflict | None
    obstacles: list[UnmetConstraint]
    costs: list[LimitPrice]
    plant_step: PlantStep | None
    warnings: list[str]
    seconds: float
    broken_again: np.ndarray
    to_settle: int | None
    further_flights: int

    @property
    def feasible(self) -> bool:
        """Whether there is anything to recommend: a point, or the default, that keeps every limit on all flights it made."""
        return bool(self.finalists.feasible[self.tuned]) and not len(self.broken_again)

    @property
    def flights(self) -> int:
        """Number of flights of search, survivors, held-out check and confirmation."""
        return (
            self.generations[-1].flights
            + self.survivors.flights
            + self.finalists.evaluation.flights
            + self.further_flights
            + self.confirmation.flights
        )

    @property
    def flights_made(self) -> int:
        """Number of these flights that were made in this session; the others were on record."""
        return self.problem.flights_made

    @property
    def names(self) -> list[str]:
        """Names of the finalists, "default" first."""
        return ["default", *[point_name(int(candidate)) for candidate in self.candidates]]

    @cached_property
    def archive(self) -> Archive:
        """All candidates of the search."""
        return archive(self.generations)

    @cached_property
    def finalist_rows(self) -> np.ndarray:
        """Gains rows (finalists, gains); row 0 is the default."""
        return finalist_gains(self.problem, self.study, self.archive, self.candidates)

    def gains(self, row: int) -> np.ndarray:
        """Return the gains row (gains,) of a finalist; row 0 is the default."""
        return self.finalist_rows[row]


FlightOutcome: TypeAlias = Outcome[TuningStudy, Problem]
"""The outcome of a run whose flights are made here."""


def finalist_gains(problem: Evaluator, study: SearchedStudy, tried: Archive, candidates: np.ndarray) -> np.ndarray:
    """Return the gains rows of the default and of the finalists."""
    return np.concatenate([study.default_row[None], problem.space.gains(tried.points[candidates])], axis=0)
