"""Judgement of candidates: requirements first, then scores of its flights, then risks over them.

`objectives.problem` makes the flights; scores may also come from elsewhere.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.flown_system import FlightBatch
from objectives.memory import FlightMemory
from objectives.metrics import MetricAddress
from objectives.requirements import (
    Requirement,
    Screen,
    first_values,
    further_values,
    hard_excess,
    known_values,
    requirement_excess,
    requirements_of,
    worth_flying,
)
from objectives.risk import (
    PROBABILITY,
    Interval,
    PairedDifference,
    Risk,
    binary_difference,
    binary_interval,
    interval_on,
    paired_difference_on,
)


@dataclass(frozen=True)
class Objective:
    """Risk of a metric over the flights of scenarios, to be minimized.

    scenario: a name, or None for all pooled.
    """

    metric: MetricAddress
    risk: Risk
    scenario: str | None = None

    @property
    def label(self) -> str:
        """Short name, unique within a study."""
        level = "" if self.risk.level is None else f"{100 * self.risk.level:g}"
        where = "" if self.scenario is None else f"@{self.scenario}"
        return f"{self.risk.name}{level}({self.metric}){where}"

    @property
    def is_binary(self) -> bool:
        """Whether every flight has 0 or 1."""
        return self.metric.metric.is_binary

    def interval(self, samples: np.ndarray, resample: np.ndarray, confidence: float = 0.95) -> Interval:
        """Return the interval of the risk of samples (..., n).

        It is exact for shares, else on resamples (replicates, n).
        """
        if self.is_binary:
            return binary_interval(samples, self.risk, confidence)
        low, high = interval_on(samples, self.risk, resample, confidence)
        # A metric is at least 0, a share at most 1, and so is every risk of it; the studentised end of a few flights need not be.
        low = np.where(np.min(samples, axis=-1) >= 0.0, np.maximum(low, 0.0), low)
        return Interval(low, np.minimum(high, self.metric.metric.highest))

    def difference(
        self, first: np.ndarray, second: np.ndarray, resample: np.ndarray, confidence: float = 0.95
    ) -> PairedDifference:
        """Return risk(first) - risk(second) with its interval as `interval`; shapes as in `paired_difference_on`."""
        if self.is_binary:
            value = self.risk.apply(first) - self.risk.apply(second)
            return PairedDifference(value, *binary_difference(first, second, self.risk, confidence))
        return paired_difference_on(first, second, self.risk, resample, confidence)


@dataclass(frozen=True)
class Constraint:
    """An objective's value that must not exceed `most`.

    floor: key of the study that moves a limit which no study writes, see `objectives.mission`; "" for a study's own limit.
    confidence: of the interval whose upper end must not exceed it either where a point is recommended; 0: the value alone.
    """

    objective: Objective
    most: float
    floor: str = ""
    confidence: float = 0.0

    @property
    def is_tail(self) -> bool:
        """Whether flights of its own decide it where a point is recommended: those of a study are too few for it."""
        return self.objective.risk.name == PROBABILITY

    @property
    def is_flown(self) -> bool:
        """Whether flights of a study decide it where a point is recommended: no automatic limit, no tail."""
        return not (self.floor or self.is_tail)

    @property
    def has_tolerance(self) -> bool:
        """Whether flights narrow an error of its value."""
        return self.is_flown and not (self.objective.is_binary or self.objective.risk.name == "worst")

    @property
    def forbids_losses(self) -> bool:
        """Whether a single lost flight breaks it."""
        return self.objective.metric.metric.name == "failure" and self.most == 0.0

    @property
    def rests_on_value(self) -> bool:
        """Whether the value alone decides on flights of a study.

        Of a worst case no interval is known, no number of flights shows a share of 0, and a tail has flights of its own.
        """
        unknown = self.objective.risk.name == "worst" or (self.objective.is_binary and self.most == 0.0)
        return self.confidence == 0.0 or unknown or self.is_tail


def relative_excess(constraints: Sequence[Constraint], excess: np.ndarray) -> np.ndarray:
    """Return the excess (n, limits) relative to each limit.

    The constraints come first, in the units of their metrics; requirements behind them are relative already. As theirs, an excess
    over 0 stays as it is.
    """
    scales = np.ones(excess.shape[1])
    scales[: len(constraints)] = [abs(entry.most) or 1.0 for entry in constraints]
    return excess / scales


@dataclass(frozen=True)
class Evaluation:
    """Results of an evaluation of n candidates.

    Attributes:
        values: Objectives (n, objectives) in the metrics' units.
        excess: Violation of constraints and requirements (n, constraints + requirements), below 0 where there is slack.
        failures: Share of flights that did not complete (n,).
        scores: The per-flight metrics that all of it came from (n, quantities, flights).
        origin: Name of the scenario of each flight (flights,).
        requirements: Values of the requirements, which need no flights (n, requirements).
        flown: False where those spared the flights, whose scores are then those of failures at t = 0 (n,).
        counted: Number of flights of each candidate (n,) where a race ended some early (`objectives.racing`), None
            where everyone flew all.
        failed: Mask of the flights that did not complete (n, flights), None where it was not recorded.
        screening_seconds: Duration of the evaluation of the requirements [s].
        flight_seconds: Duration of the flights [s].
    """

    values: np.ndarray
    excess: np.ndarray
    failures: np.ndarray
    scores: np.ndarray
    origin: np.ndarray
    requirements: np.ndarray
    flown: np.ndarray
    counted: np.ndarray | None = None
    failed: np.ndarray | None = None
    screening_seconds: float = 0.0
    flight_seconds: float = 0.0

    @property
    def violations(self) -> np.ndarray:
        """Violations of constraints and requirements (n, constraints + requirements), 0 where they are met."""
        return np.maximum(self.excess, 0.0)

    @property
    def flights_each(self) -> np.ndarray:
        """Number of flights of each candidate (n,)."""
        return self.flown * self.scores.shape[-1] if self.counted is None else self.counted

    @property
    def flights(self) -> int:
        """Number of flights made."""
        return int(self.flights_each.sum(axis=0))

    @property
    def flights_saved(self) -> int:
        """Number of flights that the requirements spared."""
        return int(np.sum(~self.flown, axis=0)) * self.scores.shape[-1]

    @property
    def flights_raced(self) -> int:
        """Number of flights that ending races early spared."""
        return int(self.flown.sum(axis=0)) * self.scores.shape[-1] - self.flights

    @property
    def lost(self) -> np.ndarray:
        """Number of flights made but not completed, of each candidate (n,)."""
        return np.rint(self.failures * self.flights_each).astype(int)

    @property
    def complete(self) -> np.ndarray:
        """Mask (n,) of the candidates that flew through every scenario."""
        return self.flown & (self.flights_each == self.scores.shape[-1])

    def samples(self, index: int, scenario: str | None) -> np.ndarray:
        """Return one quantity of the flights that count for it (n, flights); scenario: a name, or None for all."""
        return seen_scores(self.scores, index, self.origin, scenario)


# Fields of an evaluation that have a row for each candidate.
OF_CANDIDATES = ("values", "excess", "failures", "scores", "requirements", "flown")


def concatenate_evaluations(evaluations: Sequence[Evaluation]) -> Evaluation:
    """Return evaluations of several candidates on the same flights as one."""
    if len(evaluations) == 1:
        return evaluations[0]
    rows = {name: np.concatenate([getattr(entry, name) for entry in evaluations], axis=0) for name in OF_CANDIDATES}
    failed = [entry.failed for entry in evaluations if entry.failed is not None]
    counted = [entry.flights_each for entry in evaluations]
    return replace(
        evaluations[0],
        **rows,
        counted=None if all(entry.counted is None for entry in evaluations) else np.concatenate(counted),
        failed=np.concatenate(failed) if len(failed) == len(evaluations) else None,
        screening_seconds=sum(entry.screening_seconds for entry in evaluations),
        flight_seconds=sum(entry.flight_seconds for entry in evaluations),
    )


def seen_scores(scores: np.ndarray, index: int, origin: np.ndarray, scenario: str | None) -> np.ndarray:
    """Return scores (n, flights) of one quantity in one scenario or all.

    scenario: a name, or None for all.
    Contiguous, because numpy sums in another order along other layouts: a candidate's bits must not depend on its batch.
    """
    return scores[:, index] if scenario is None else np.ascontiguousarray(scores[:, index][:, origin == scenario])


class Evaluator(ABC):
    """Evaluates points of the unit cube: requirements, every candidate worth it through every scenario, metrics, risks.

    A subclass gives the scores, by flights of a system (`Problem`) or from elsewhere. spared(n) is called in place of
    on_flights_done, if set, for flights that are known or not made at all. memory: of flights already flown; flights_made counts
    those that it did not know. now: seconds, of which differences are noted as the time that an evaluation took.
    """

    spared: Callable[[int], None] | None = None
    memory: FlightMemory | None = None
    flights_made = 0
    now: Callable[[], float] = staticmethod(perf_counter)

    def __init__(
        self,
        space: DecisionSpace,
        objectives: tuple[Objective, ...],
        constraints: tuple[Constraint, ...],
        screens: tuple[Screen, ...] = (),
    ) -> None:
        self.space = space
        self.objectives = objectives
        self.constraints = constraints
        self.screens = screens

    @property
    def quantities(self) -> tuple[Objective, ...]:
        """Objectives first, then what is constrained."""
        return (*self.objectives, *(constraint.objective for constraint in self.constraints))

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """Requirements that need no flight, in the order of their columns."""
        return requirements_of(self.screens)

    def worth_flying(self, points: np.ndarray) -> np.ndarray:
        """Return the mask (n,) of points (n, d) that satisfy every hard requirement."""
        return worth_flying(self.requirements, known_values(self.screens, self.space.gains(points)))

    def excess(self, points: np.ndarray) -> np.ndarray:
        """Return the relative excess (n, h) of points (n, d) over hard requirements.

        It is relative to the limit, and below 0 where the limit is met.
        """
        return hard_excess(self.requirements, known_values(self.screens, self.space.gains(points)))

    @property
    def excesses(self) -> tuple[Callable[[np.ndarray], np.ndarray], ...]:
        """The parts of `excess`: functions of points (n, d), the longest last."""
        several = any(screen.further for screen in self.screens)
        return (self._excess, self._further_excess) if several else (self._excess,)

    def _excess(self, points: np.ndarray) -> np.ndarray:
        return hard_excess(self.requirements, first_values(self.screens, self.space.gains(points)))

    def _further_excess(self, points: np.ndarray) -> np.ndarray:
        return hard_excess(self.requirements, further_values(self.screens, self.space.gains(points)))

    def evaluate(
        self,
        points: np.ndarray,
        batches: tuple[FlightBatch, ...],
        on_flights_done: Callable[[int], None] | None = None,
        fly_all: bool | np.ndarray = False,
    ) -> Evaluation:
        """Evaluate candidates that are points of the unit cube.

        Args:
            points: Coordinates (n, variables) in [0, 1].
            batches: The flights that every candidate makes.
            on_flights_done: Called with n as n more flights have ended or been spared.
            fly_all: Fly what breaks a hard requirement too; a mask (n,) says so for single candidates.

        Returns:
            Scores, risks, violations and requirement values of the candidates.
        """
        return self.evaluate_gains(self.space.gains(points), batches, on_flights_done, fly_all)

    def evaluate_gains(
        self,
        gains: np.ndarray,
        batches: tuple[FlightBatch, ...],
        on_flights_done: Callable[[int], None] | None = None,
        fly_all: bool | np.ndarray = False,
        complete: bool = False,
    ) -> Evaluation:
        """Evaluate gains rows (n, gains), else as `evaluate`; scores are ordered by batch, then by scenario index.

        complete: whether requirements are judged in all conditions, see `known_values`.
        """
        begin = self.now()
        limited = known_values(self.screens, gains, complete)
        screened = self.now()
        flown = worth_flying(self.requirements, limited) | fly_all
        scores, failed, origin = [], [], []
        for batch in batches:
            for first, last in self.chunks(batch):
                part, status = self.scored(gains, flown, batch, first, last, on_flights_done)
                scores.append(part)
                failed.append(status)
                origin += [batch.spec.name] * (last - first)
        lost = np.concatenate(failed, axis=-1)
        all_scores, names = np.concatenate(scores, axis=-1), np.array(origin)
        risks = self.risks(all_scores, names)
        n = len(self.objectives)
        return Evaluation(
            values=risks[:, :n],
            excess=np.concatenate(
                [self.constraint_excess(risks), requirement_excess(self.requirements, limited)], axis=1
            ),
            failures=lost.mean(axis=-1),
            scores=all_scores,
            origin=names,
            requirements=limited,
            flown=flown,
            failed=lost,
            screening_seconds=screened - begin,
            flight_seconds=self.now() - screened,
        )

    def constraint_excess(self, risks: np.ndarray) -> np.ndarray:
        """Return the excess of risks (n, quantities) over constraints (n, constraints): below 0 where there is slack."""
        return risks[:, len(self.objectives) :] - np.array([constraint.most for constraint in self.constraints])

    def risks(self, scores: np.ndarray, origin: np.ndarray) -> np.ndarray:
        """Return the risk of every quantity (n, quantities) of scores (n, quantities, flights); NaN without flights.

        The last flights of a search may hold none of a scenario that is flown whole by every candidate.
        """
        risks = np.full(scores.shape[:2], np.nan)
        for i, quantity in enumerate(self.quantities):
            seen = seen_scores(scores, i, origin, quantity.scenario)
            if seen.shape[-1]:
                risks[:, i] = quantity.risk.apply(seen)
        return risks

    def spare(self, flights: int, on_flights_done: Callable[[int], None] | None) -> None:
        """Report skipped flights to the watcher."""
        report = on_flights_done and (self.spared or on_flights_done)
        if report is not None and flights:
            report(flights)

    @abstractmethod
    def scored(
        self,
        gains: np.ndarray,
        flown: np.ndarray,
        batch: FlightBatch,
        first: int,
        last: int,
        on_flights_done: Callable[[int], None] | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return scores (n, quantities, last - first) and failures (n, last - first) of gains rows (n, g).

        Those that are not `flown` (n,) count as lost at t = 0.
        """

    @abstractmethod
    def unflown(self, batch: FlightBatch, flights: int) -> tuple[np.ndarray, np.ndarray]:
        """Return scores (1, quantities, flights) and failures (1, flights) of one that was not worth a flight: lost at t = 0."""

    def chunks(self, batch: FlightBatch) -> list[tuple[int, int]]:
        """Return the consecutive ranges of flights of a batch, by default one."""
        return [(batch.start, batch.count)]
