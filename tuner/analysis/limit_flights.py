"""Further held-out flights of points whose interval straddles a limit.

The held-out flights of a study decide most limits, and near one that binds they decide nothing: value within, end of interval
beyond. Such a point flies on, to twice the flights each time and half of the budget at most, 16 times or more, and its interval
is looked at each time. The point with the most flights narrows the intervals of others, see `tuner.analysis.paired_estimates`.
Looks spend the error that the study allows, the first a half of it and further ones the rest alike (K. K. G. Lan, D. L. DeMets,
Biometrika 70(3):659-663, 1983), so a point that breaks its limit passes in any of them no more often than by one interval.
"""

from collections.abc import Callable
from dataclasses import replace
from math import ceil
from typing import NamedTuple

import numpy as np

from objectives.engine import LANES
from objectives.evaluator import Constraint, Evaluator
from objectives.flown_system import FlightBatch
from objectives.problem import Problem
from objectives.risk import RELEVANT, PairedDifference, flights_to_show, resampled_scenarios, within
from plant.seeds import generator
from tuner.analysis.air_losses import air_losses, excused
from tuner.analysis.final_flights import FinalFlights
from tuner.analysis.paired_estimates import Paired, paired_estimate

FIRST_SHARE = 0.5
"""Share of the allowed error that the look at the held-out flights spends; further looks spend the rest in equal parts."""
BUDGET = 32
"""Further flights of all points together, in held-out flights of the study."""
MIN_STEPS = 4_000_000
"""Plant steps that further flights in compiled code may take in any case.

A plant's flight of 400 steps takes 0.2 ms: with 8,192 flights in place of 2,048 a search took 8 % longer, and where a limit on
overshoot binds its error was 1.8 instead of 3.1 % from the best.
"""
MAX_FLIGHTS_FOR_SHARE = 20_000
"""Flights of a point at most to show that a share of events is within its limit."""
DOUBT = 2
"""Ratio of foreseen flights to those of the last look up to which a row is worth them: few skewed flights foresee too many."""
REPLICATES, PAIR_REPLICATES = 2000, 400


class Look(NamedTuple):
    """A look at the limits of all rows.

    Attributes:
        value: Values (rows, constraints).
        low: Lower ends of intervals; those that rest on their value have it thrice.
        upper: Upper ends.
        excess: Excess (rows, constraints), 0 where a limit is kept in this look or was in an earlier one.
        is_open: Mask (rows,) of those that may fly on: they keep every limit by value and not by interval.
        is_possible: Mask (rows,) of those that may fly on: they keep each limit by the lower end of an interval alone.
    """

    value: np.ndarray
    low: np.ndarray
    upper: np.ndarray
    excess: np.ndarray
    is_open: np.ndarray
    is_possible: np.ndarray


class LimitFlights:
    """Looks at the limits of finalists; flights: number of further flights.

    Args:
        problem: Makes the flights; another program's trials are not asked for more.
        gains: Rows (rows, g), the default first.
        batches: Held-out flights of the study.
        root: Root seed of the resamples.
        on_flights_done: Called with n as n more flights have ended.
        relevant: Share of the default's value from which a difference matters.
    """

    def __init__(
        self,
        problem: Evaluator,
        gains: np.ndarray,
        batches: tuple[FlightBatch, ...],
        root: int,
        on_flights_done: Callable[[int], None] | None = None,
        relevant: float = RELEVANT,
    ) -> None:
        self.problem, self.gains, self.batches, self.root, self.relevant = problem, gains, batches, root, relevant
        self.on_flights_done, self.may_fly = on_flights_done, isinstance(problem, Problem)
        self.flights = 0
        self._each = sum(batch.count for batch in batches)
        self._budget = most_further_flights(problem, batches) if isinstance(problem, Problem) else 0
        # A row makes half of the budget at most, so at least two rows may make all looks.
        self.n_looks = max((self._budget // max(2 * self._each, 1)).bit_length(), 1)
        self._looks = np.zeros(len(gains), dtype=int)
        self._passed = np.zeros((len(gains), len(problem.constraints)), dtype=bool)
        self._further: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        self._counts: dict[int, list[int]] = {}
        self._intervals: dict[tuple[int, float, bytes], tuple[float, float, float]] = {}
        self._closed: set[int] = set()
        self._differences: dict[tuple[int, int, int, int], PairedDifference] = {}
        self._paired: dict[tuple[int, int], Paired] = {}

    def confidence(self, entry: Constraint, look: int) -> float:
        """Return the confidence of an interval at a look."""
        return spent_confidence(entry.confidence, look, self.n_looks) if self.may_fly else entry.confidence

    def look(self, flown: FinalFlights) -> Look:
        """Return the look at all flights made so far; a limit once kept by its interval stays kept while its value keeps it."""
        value, low, upper = self._estimates(flown)
        entries = self.problem.constraints
        most = np.array([bound(entry, value[0, i], self.relevant) for i, entry in enumerate(entries)])
        self._passed = (self._passed | (upper <= most)) & (value <= most)
        excess = np.maximum(np.where(self._passed, value, upper) - most, 0.0)
        required = flown.evaluation.violations[:, len(entries) :]
        straddles = np.all(low <= most, axis=1) & np.any(excess > 0.0, axis=1) & np.all(required <= 0.0, axis=1)
        may = np.array([self._has_looks_left(row) for row in range(len(value))])
        return Look(value, low, upper, excess, np.all(value <= most, axis=1) & straddles & may, straddles & may)

    def _has_looks_left(self, row: int) -> bool:
        """Return True for a row that may make further looks."""
        return bool(self._looks[row] + 1 < self.n_looks) and row not in self._closed

    def _estimates(self, flown: FinalFlights) -> np.ndarray:
        """Return values with both ends of their intervals (3, rows, constraints)."""
        first = len(self.problem.objectives)
        parts = np.empty((3, len(self.gains), len(self.problem.constraints)))
        for i, entry in enumerate(self.problem.constraints):
            parts[:, :, i] = flown.value(first + i)
            if not rests_on_value(entry):
                parts[:, :, i] = flown.estimate(first + i, self.confidence(entry, 0))
            for row in self._further:
                parts[:, row, i] = self._remembered_interval(flown, row, i, self.confidence_of(entry, row))
        self._paired = self._pairs(flown, parts)
        for (row, i), paired in self._paired.items():
            parts[:, row, i] = paired.estimate
        return parts

    def _pairs(self, flown: FinalFlights, parts: np.ndarray) -> dict[tuple[int, int], Paired]:
        """Return intervals by row and constraint that the leader narrows.

        There are none with several objectives: further points of a motor's front moved its pick from -19 to +58 % of the error.
        parts (3, rows, constraints): values and ends by the flights of each row alone.
        """
        if not self._further or len(self.problem.objectives) > 1:
            return {}
        leader = self.leader
        pairs = {
            (row, i): paired_estimate(parts[:, row, i], parts[:, leader, i], difference)
            for i, entry in enumerate(self.problem.constraints)
            if entry.has_tolerance and not rests_on_value(entry)
            for row in np.flatnonzero(flown.complete).tolist()
            if (difference := self._difference(flown, row, leader, i)) is not None
        }
        return {key: paired for key, paired in pairs.items() if paired is not None}

    def _difference(self, flown: FinalFlights, row: int, leader: int, i: int) -> PairedDifference | None:
        """Return the difference on the flights of both rows, if any.

        There is none where the leader made no others.
        """
        (scores, origin), (others, longer) = self.samples(flown, row), self.samples(flown, leader)
        if len(longer) <= len(origin) or not np.array_equal(longer[: len(origin)], origin):
            return None
        entry, key = self.problem.constraints[i], (row, leader, i, len(origin))
        if key not in self._differences:
            both = self._seen(scores, origin, i), self._seen(others[:, : len(origin)], origin, i)
            drawn = resampled_scenarios(generator(self.root, "bootstrap/limit-pairs", i), PAIR_REPLICATES, origin)
            resample = within(drawn, origin, entry.objective.scenario)
            self._differences[key] = entry.objective.difference(*both, resample, self.confidence_of(entry, leader))
        return self._differences[key]

    def _remembered_interval(
        self, flown: FinalFlights, row: int, i: int, confidence: float
    ) -> tuple[float, float, float]:
        """Return the interval of a row, resampled once for the same flights."""
        scores, origin = self.samples(flown, row)
        key = i, confidence, scores[len(self.problem.objectives) + i].tobytes()
        if key not in self._intervals:
            self._intervals[key] = self.interval(scores, origin, i, confidence)
        return self._intervals[key]

    @property
    def leader(self) -> int:
        """Return the row with the most flights."""
        return max(self._further, key=lambda row: sum(self._counts[row]))

    def flier(self, row: int) -> int:
        """Return the row whose flights narrow the interval of a row most: the row itself, or the leader."""
        paired = [pair for (other, _), pair in self._paired.items() if other == row]
        is_led = bool(paired) and all(pair.is_led for pair in paired)
        return self.leader if is_led and self._has_looks_left(self.leader) else row

    def shown(self, look: Look, flown: FinalFlights) -> np.ndarray:
        """Return values and intervals (3, rows, constraints) to show.

        If values decide, the interval is the usual one.
        """
        parts, first = np.array([look.value, look.low, look.upper]), len(self.problem.objectives)
        for i, entry in enumerate(self.problem.constraints):
            if rests_on_value(entry):
                parts[:, :, i] = flown.estimate(first + i)
        return parts

    def samples(
        self, flown: FinalFlights, row: int, further: tuple[np.ndarray, np.ndarray] | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return scores (quantities, flights) of a row, and the scenarios; further: next to its own."""
        parts = [
            (flown.scores[row], flown.origin),
            *[part for part in (self._further.get(row), further) if part is not None],
        ]
        return np.concatenate([scores for scores, _ in parts], axis=-1), np.concatenate([origin for _, origin in parts])

    def interval(self, scores: np.ndarray, origin: np.ndarray, i: int, confidence: float) -> tuple[float, float, float]:
        """Return the value of a constraint with both ends of its interval.

        It is that over scores (quantities, flights).
        """
        entry = self.problem.constraints[i]
        objective, seen = entry.objective, self._seen(scores, origin, i)
        value = float(objective.risk.apply(seen))
        if rests_on_value(entry):
            return value, value, value
        drawn = resampled_scenarios(generator(self.root, "bootstrap/limit-flights", i), REPLICATES, origin)
        low, high = objective.interval(seen, within(drawn, origin, objective.scenario), confidence)
        return value, float(low), float(high)

    def _seen(self, scores: np.ndarray, origin: np.ndarray, i: int) -> np.ndarray:
        """Return the scores of a constraint in its scenarios."""
        scenario, row = self.problem.constraints[i].objective.scenario, scores[len(self.problem.objectives) + i]
        return row if scenario is None else row[origin == scenario]

    def confidence_of(self, entry: Constraint, row: int) -> float:
        """Return the confidence of a row's interval: that of its latest look, of the study without further flights."""
        return self.confidence(entry, int(self._looks[row])) if row in self._further else entry.confidence

    def fly(self, row: int, excess: np.ndarray, is_recommended: bool = False) -> bool:
        """Have a row make the flights up to its next look.

        False where it has made all looks, or the budget has no room for them.

        Args:
            row: Number of the row.
            excess: Excess (constraints,) of it.
            is_recommended: Whether it is the recommended row, for which no budget counts.
        """
        number, made = int(self._looks[row]) + 1, self._counts.get(row, [batch.count for batch in self.batches])
        if number >= self.n_looks:
            return False
        wanted = self._wanted(excess, number)
        flights = sum(wanted) - sum(made)
        if flights <= 0 or (flights > self._budget - self.flights and not is_recommended):
            self._closed.add(row)
            return False
        parts = [
            self._flown(row, replace(batch, start=begin, count=end))
            for batch, begin, end in zip(self.batches, made, wanted, strict=True)
            if end > begin
        ]
        before = [self._further[row]] if row in self._further else []
        scores, origins = zip(*before, *parts, strict=True)
        self._further[row] = np.concatenate(scores, axis=-1), np.concatenate(origins)
        self._looks[row], self._counts[row] = number, wanted
        self.flights += flights
        return True

    def _wanted(self, excess: np.ndarray, number: int) -> list[int]:
        """Return the numbers of flights, by batch, of a further look; excess (constraints,)."""
        wanted = [batch.count * 2**number for batch in self.batches]
        for i in np.flatnonzero(excess > 0.0):
            entry = self.problem.constraints[i]
            if entry.objective.is_binary and entry.objective.risk.is_mean and entry.most > 0.0:
                enough = flights_to_show(entry.most, self.confidence(entry, number))
                scenarios = [entry.objective.scenario in (None, batch.spec.name) for batch in self.batches]
                each = ceil(min(enough, MAX_FLIGHTS_FOR_SHARE) / max(sum(scenarios), 1))
                wanted = [max(n, each) if counts else n for n, counts in zip(wanted, scenarios, strict=True)]
                self._budget = max(self._budget, 4 * min(enough, MAX_FLIGHTS_FOR_SHARE))
        return wanted

    def _flown(self, row: int, batch: FlightBatch) -> tuple[np.ndarray, np.ndarray]:
        """Return scores (quantities, flights) and scenarios of further flights; those that the air lost do not count."""
        assert isinstance(self.problem, Problem)
        ranges, everyone = self.problem.chunks(batch), np.ones(1, dtype=bool)
        parts = [
            self.problem.scored(self.gains[[row]], everyone, batch, first, last, self.on_flights_done)
            for first, last in ranges
        ]
        scores = np.concatenate([part for part, _ in parts], axis=-1)
        failed = np.concatenate([lost for _, lost in parts], axis=-1)[0]
        origin = np.repeat(batch.spec.name, scores.shape[-1])
        air = air_losses(self.problem, self.gains, (batch,), failed)
        return (excused(self.problem, scores, origin, air) if air.any() else scores)[0], origin

    def looked_at(self) -> dict[int, int]:
        """Return the number of flights by row that made further ones."""
        return {row: sum(counts) for row, counts in self._counts.items()}

    def may_settle(self, look: Look, flown: FinalFlights, share: float = 0.0) -> np.ndarray:
        """Return the mask (rows,) of those likely to settle.

        They take at most `DOUBT` times the flights of the last look, by values and intervals so far.
        share: Part of the interval below a value by which the value counts as smaller.
        """
        shift = share * (look.value - look.low)
        look = look._replace(value=look.value - shift, upper=look.upper - shift)
        last = 2 ** (self.n_looks - 1) * self._each
        most = np.full(len(self.gains), DOUBT * last)
        shares = [entry.objective.is_binary for entry in self.problem.constraints]
        most[np.any(look.excess[:, shares] > 0.0, axis=1)] = MAX_FLIGHTS_FOR_SHARE
        settled = [self.flights_to_settle(look, flown, row) for row in range(len(self.gains))]
        return np.array([count is not None and count <= allowed for count, allowed in zip(settled, most, strict=True)])

    def flights_to_settle(self, look: Look, flown: FinalFlights, row: int) -> int | None:
        """Return the approximate number of flights that settles a row's limits.

        None where its values break one.
        """
        if np.any(flown.evaluation.violations[row, len(self.problem.constraints) :] > 0.0):
            return None
        value, upper = look.value[row], look.upper[row]
        made, flights = sum(self._counts.get(row, [batch.count for batch in self.batches])), list[float]()
        for i in np.flatnonzero(look.excess[row] > 0.0):
            entry = self.problem.constraints[i]
            slack = entry.most - value[i]
            if slack <= 0.0:
                return None
            # The end of a share's interval comes down as 1 / n without an event, else as 1 / sqrt(n) as any other's.
            power = 1.0 if entry.objective.is_binary and value[i] == 0.0 else 2.0
            paired = self._paired.get((row, int(i)))
            above = paired.above if paired else float(upper[i] - value[i])
            flights.append(made * (above / slack) ** power)
        return ceil(max(flights, default=made))


def most_further_flights(problem: Problem, batches: tuple[FlightBatch, ...]) -> int:
    """Return the number of further flights that all points together may make."""
    flights, timing = sum(batch.count for batch in batches), problem.system.timing
    steps = sum(batch.count * batch.spec.steps(timing) * timing.steps for batch in batches)
    # A step of a model unit may take as long as a flight of these.
    cheap = MIN_STEPS * flights // max(steps, 1) if problem.system.arithmetic == LANES else 0
    return max(BUDGET * flights, cheap)


def spent_confidence(confidence: float, look: int = 0, n_looks: int = 1) -> float:
    """Return the confidence of an interval at one of several looks."""
    share = (1.0 - FIRST_SHARE) / (n_looks - 1) if look else FIRST_SHARE
    return 1.0 - (1.0 - confidence) * share


def rests_on_value(entry: Constraint) -> bool:
    """Return True where the value alone decides: of known and of automatic limits."""
    return entry.rests_on_value or bool(entry.floor)


def bound(entry: Constraint, default: float, relevant: float = RELEVANT) -> float:
    """Return the largest value that keeps a limit: an automatic one allows all but a relevant loss to the default."""
    return max(entry.most, (1.0 + relevant) * default) if entry.floor else entry.most
