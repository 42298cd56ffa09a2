"""Limits of a study on rare events.

Flights of a study cannot show a probability far below one over their number. So the search and the held-out check judge such a
limit by the share of their own flights, and the point that would be recommended must keep it by an estimate of its own, on a
stream that decided nothing. Otherwise the next point is judged, up to `MAX_POINTS` of them. That one of several satisfies a
limit by chance is no likelier than for one: they share the error of the confidence (Bonferroni), half of it for the first, half
of the rest for each next, so that the first, which mostly passes, pays least: 97.5 % in place of 95 %, 1.3 times the flights.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

import numpy as np

from objectives.problem import Constraint, Evaluation
from tuner.documents.parts import Estimate, ShareCount
from tuner.documents.summary import ComparedRow
from tuner.documents.tail import LimitedTail, TailEvent
from tuner.documents.verdicts import verdict_on_limit
from tuner.extensions.tails.estimation.crude import BATCH
from tuner.extensions.tails.estimation.estimate import estimate_tail
from tuner.extensions.tails.estimation.limit_function import Method
from tuner.extensions.tails.estimation.planning import Request, choose_method, expected_evaluations
from tuner.extensions.tails.events import read_event
from tuner.extensions.tails.flight_limit import FlightLimit
from tuner.extensions.tails.tail_event import tail_event
from tuner.search.watcher import Watcher
from tuner.study.study import StudyScenario, TuningStudy

STAGE = "Estimating rare losses"
MAX_POINTS = 5
"""Points that are judged by estimates of their own."""
SMALLEST_SHARE = 0.3
"""Probability over the limit below which no estimate is needed."""
WIDTH = 1.0
"""Width of the interval over the probability."""
MAX_FLIGHTS = 1_000_000
"""Flights of an estimate at most."""
FIRST_SHARE = 1.31
"""Flights of the first point, at 97.5 %, over those of an estimate at 95 %: (2.241 / 1.960)^2."""
CONFIDENCE = 0.95
"""Confidence of the interval if the study names none."""


class TailValue(NamedTuple):
    """Probability of an event with its interval.

    Attributes:
        probability: Probability; of several scenarios the one with the largest upper end.
        confidence: Confidence of the interval.
        low, high: Ends of its interval.
        flights: Flights of all scenarios.
        events: Estimates by names of scenarios.
    """

    probability: float
    low: float
    high: float
    flights: int
    events: Mapping[str, TailEvent]
    confidence: float = CONFIDENCE


def scenarios_of(study: TuningStudy, limit: Constraint) -> list[StudyScenario]:
    """Return the scenarios that a limit is about."""
    return [entry for entry in study.scenarios if limit.objective.scenario in (None, entry.spec.name)]


def expected_flights(limit: Constraint) -> int:
    """Return the flights in a scenario where the limit is just kept."""
    return ceil(FIRST_SHARE * expected_evaluations(limit.most, WIDTH, choose_method(limit.most)))


def confidence_of(limit: Constraint, place: int) -> float:
    """Return the confidence of the point judged at a place, from 0."""
    error = 1.0 - (limit.confidence or CONFIDENCE)
    return 1.0 - error * 0.5 ** min(place + 1, MAX_POINTS - 1)


def smallest_of(limit: Constraint) -> float:
    """Return the probability down to which a limit's estimate looks."""
    return SMALLEST_SHARE * limit.most


@dataclass(frozen=True)
class TailLimits:
    """The limits of a study on rare events.

    Attributes:
        study: Study whose gains are judged.
        threads: Threads that fly.
        watcher: Callbacks.
    """

    study: TuningStudy
    threads: int | None
    watcher: Watcher

    @property
    def limits(self) -> dict[int, Constraint]:
        """Limits by their index among the constraints of the study."""
        return {i: entry for i, entry in enumerate(self.study.constraints) if entry.is_tail}

    def announce(self) -> None:
        """Announce the flights of a point that just keeps its limits."""
        flights = [expected_flights(limit) * len(scenarios_of(self.study, limit)) for limit in self.limits.values()]
        self.watcher.on_stage(STAGE, sum(flights))

    def values(self, gains: np.ndarray, place: int) -> dict[int, TailValue]:
        """Return the probabilities under gains (g,), judged at a place."""
        return {i: self._value(gains, limit, confidence_of(limit, place)) for i, limit in self.limits.items()}

    def _value(self, gains: np.ndarray, limit: Constraint, confidence: float) -> TailValue:
        scenarios = scenarios_of(self.study, limit)
        events = {entry.spec.name: self._event(gains, limit, entry, confidence) for entry in scenarios}
        worst = max(events.values(), key=lambda event: event.high)
        flights = sum(event.flights for event in events.values())
        return TailValue(worst.probability, worst.low, worst.high, flights, events, confidence)

    def counted(self, gains: np.ndarray, limit: Constraint, entry: StudyScenario, confidence: float) -> TailEvent:
        """Return the estimate by one batch of independent flights."""
        return self._event(gains, limit, entry, confidence, BATCH, Method.CRUDE)

    def _event(
        self,
        gains: np.ndarray,
        limit: Constraint,
        entry: StudyScenario,
        confidence: float,
        most: int = MAX_FLIGHTS,
        method: Method | None = None,
    ) -> TailEvent:
        # Of a limit that crude flights can show, nothing rarer matters.
        if choose_method(limit.most) is Method.CRUDE:
            method = Method.CRUDE
        request = Request(WIDTH, smallest_of(limit), most, confidence, method)
        event = read_event(limit.objective.metric.text, self.study.system, entry.spec)
        flown = FlightLimit(event, entry.spec, gains, self.threads, self.watcher.on_flights_done)
        return tail_event(event, estimate_tail(flown, self.study.seed, request))


class FinalistTails:
    """Finalists judged by the limits on rare events, one after the other.

    Args:
        limits: Limits of the study.
        gains: Gains of the finalists (rows, g).
    """

    def __init__(self, limits: TailLimits, gains: np.ndarray) -> None:
        self._limits, self._gains = limits, gains
        self.values: dict[int, dict[int, TailValue]] = {}

    @property
    def flights(self) -> int:
        """Number of flights made."""
        return sum(value.flights for made in self.values.values() for value in made.values())

    @property
    def excess(self) -> np.ndarray:
        """Excess (rows, constraints) over the limits at their confidence.

        0 where nothing is known, and infinite for all others once `MAX_POINTS` points were judged and broke them.
        """
        limits, constraints = self._limits.limits, self._limits.study.constraints
        excess = np.zeros((len(self._gains), len(constraints)))
        for row, values in self.values.items():
            for i, value in values.items():
                excess[row, i] = max(value.high - limits[i].most, 0.0)
        if len(self.values) >= MAX_POINTS and all(excess[row].any() for row in self.values):
            others = [row for row in range(len(excess)) if row not in self.values]
            excess[np.ix_(others, list(limits))] = np.inf
        return excess

    def judge(self, row: int) -> bool:
        """Return True if this call estimated the probabilities of a row.

        False where they were estimated before.
        """
        if row in self.values:
            return False
        self._limits.announce()
        self.values[row] = self._limits.values(self._gains[row], len(self.values))
        return True

    def rows(self, table: Sequence[ComparedRow], row: int, confirmation: Evaluation) -> list[ComparedRow]:
        """Return a table with the estimates of a row.

        They stand in place of the shares of its flights, which were tuned values.

        Args:
            table: Table of objectives and constraints.
            row: Row of the finalists.
            confirmation: Flights of the default and of that row.
        """
        first = len(self._limits.study.objectives)
        made = {first + i: value for i, value in self.values.get(row, {}).items()}
        if made:
            self._limits.watcher.on_stage(STAGE, BATCH * sum(len(value.events) for value in made.values()))
        return [
            _estimated(entry, made[i], self._tails(i, made[i], confirmation)) if i in made else entry
            for i, entry in enumerate(table)
        ]

    def _tails(self, quantity: int, value: TailValue, confirmation: Evaluation) -> list[LimitedTail]:
        """Return the tails of an estimated quantity and of the default."""
        study = self._limits.study
        limit = study.constraints[quantity - len(study.objectives)]
        scenarios = {entry.spec.name: entry for entry in study.scenarios}
        tails = []
        for name, tuned in value.events.items():
            default_count, tuned_count = map(ShareCount.of, confirmation.samples(quantity, name))
            tails.append(
                LimitedTail(
                    scenario=name,
                    confidence=value.confidence,
                    smallest=smallest_of(limit),
                    width=WIDTH,
                    tuned=tuned,
                    default=self._limits.counted(self._gains[0], limit, scenarios[name], value.confidence),
                    tuned_count=tuned_count,
                    default_count=default_count,
                )
            )
        return tails


def _estimated(row: ComparedRow, value: TailValue, tails: list[LimitedTail]) -> ComparedRow:
    assert row.limit is not None, "an estimate is of a limit"
    return row.model_copy(
        update={
            "tuned": Estimate(value.probability, value.low, value.high),
            "tuned_count": None,
            "difference": Estimate(None, None, None),
            "verdict": verdict_on_limit(value.probability, row.limit, high=value.high),
            "tail_flights": value.flights,
            "tails": tails,
        }
    )
