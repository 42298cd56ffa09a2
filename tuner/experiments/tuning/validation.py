"""Validation of finalists: held-out flights, further ones where a limit is open, and confirmation of the point picked."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from objectives.evaluator import Evaluation, Evaluator, relative_excess
from objectives.problem import Problem
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT
from plant.ties import first_smallest
from tuner.analysis.air_losses import air_losses, air_of_finals, excused_evaluation, excused_finals, losses
from tuner.analysis.final_flights import FinalFlights
from tuner.analysis.finals import Finals
from tuner.analysis.held_out import Finalists, SearchEstimate, judge
from tuner.analysis.limit_flights import LimitFlights, Look
from tuner.analysis.lost_flights import named_losses
from tuner.experiments.tuning.finalist_limits import FinalistLimits
from tuner.experiments.tuning.problem import batches
from tuner.experiments.tuning.recommendation import Default, best_row, choose_finalist
from tuner.search.front import non_dominated
from tuner.search.watcher import Watcher
from tuner.study.searched import SearchedStudy
from tuner.text.sentences import counted

STANDARD_ERROR = 0.5
"""Standard error of a value in the part of its interval below it."""
NEGLIGIBLE_SHARE = 0.25
"""Share of a difference that matters up to which a better objective is worth no flights."""
MAX_CONFIRMED_POINTS = 5
"""Points that are confirmed one after the other, where confirmation flights show that the one before breaks a limit."""


@dataclass(frozen=True)
class Validated:
    """Result of held-out and confirmation flights.

    Attributes:
        finalists: Judged by held-out flights.
        tuned: Row of the recommended point, 0 for the default, or of the nearest where nothing keeps every limit.
        why: Reason.
        confirmation: The default and that row.
        broken: Constraints that it breaks on confirmation flights.
        to_settle: About the flights that would decide that the nearest keeps its limits, None where its values break one.
        further_flights: Number of flights made because limits were open.
    """

    finalists: Finalists
    tuned: int
    why: str
    confirmation: Evaluation
    broken: np.ndarray
    warnings: list[str]
    to_settle: int | None
    further_flights: int

    @property
    def keeps(self) -> bool:
        """Whether the row keeps every limit."""
        return bool(self.finalists.feasible[self.tuned]) and not len(self.broken)


class Validation:
    """Validates finalists, gains (rows, g) with the default first; names: of the rows, seen: each in the search.

    worst: mask (m,) of the objectives in which the default is among the worst of all that was tried.
    """

    def __init__(
        self,
        problem: Evaluator,
        study: SearchedStudy,
        gains: np.ndarray,
        names: Sequence[str],
        seen: list[SearchEstimate],
        worst: np.ndarray,
        watcher: Watcher,
        tails: FinalistLimits | None = None,
    ) -> None:
        self.problem, self.study, self.gains, self.names = problem, study, gains, names
        self._seen, self._tails, self._say, self._worst = seen, tails, watcher.on_flights_done, worst
        self._flown, self._confirmed = batches(study, HELD_OUT), batches(study, CONFIRMATION)
        self._limits = LimitFlights(problem, gains, self._flown, study.seed, self._say, study.table.relevant)
        self._struck = np.zeros((len(gains), len(problem.constraints)))
        self._warnings: dict[str, None] = {}

    def conclude(self) -> Validated:
        """Fly the finalists, pick one and confirm it; one that confirmation flights refute makes way for the next."""
        choose = partial(best_row, self.study, self._worst)
        finals = Finals(self.problem, self.gains, self._flown, choose, self.study.seed, self._say)
        flown, validated = self._judged(finals, finals.fly())
        first = validated
        for attempt in range(MAX_CONFIRMED_POINTS):
            if validated.keeps or not validated.finalists.feasible[validated.tuned]:
                break
            self._strike(validated, attempt)
            flown, validated = self._judged(finals, flown)
        # What comes nearest is the first that was picked, not the last that was refuted.
        return validated if validated.keeps else first

    def _strike(self, validated: Validated, attempt: int) -> None:
        """Leave a refuted row out; the last one leaves nothing but the default.

        If no flight may be lost, all that lose the same flights make way with it. From the second one on so do all that the same
        difference puts beyond a limit: five neighbors, one by one, ended a hover's run before nine points further inside.
        """
        labels = [self.problem.constraints[i].objective.label for i in validated.broken]
        self._struck[validated.tuned, validated.broken] = np.inf
        others = np.all(self._struck == 0.0, axis=1, keepdims=True)
        others[0] = False
        losing = self._losing_alike(validated)
        beyond = self._breaking_alike(validated) if attempt else np.zeros_like(losing)
        self._struck[losing | beyond] = np.inf
        if attempt + 1 == MAX_CONFIRMED_POINTS:
            self._struck[1:, validated.broken] = np.inf
        reasons = ((losing, "lose the same flights"), (beyond, "the same difference would put beyond the limit"))
        counts = [(int(np.count_nonzero(np.any(alike & others, axis=1))), reason) for alike, reason in reasons]
        with_it = "".join(
            f", and {counted(count, 'further point')} with it that {reason}" for count, reason in counts if count
        )
        self._warnings[
            f"{self.names[validated.tuned]} satisfies every limit on held-out flights and breaks {', '.join(labels)} on "
            f"confirmation flights, so it makes way{with_it}."
        ] = None

    def _losing_alike(self, validated: Validated) -> np.ndarray:
        """Return the mask (rows, constraints) of rows that share its losses.

        Only constraints count that the tuned row breaks and that forbid losses.
        """
        out, failed = np.zeros_like(self._struck, dtype=bool), validated.confirmation.failed
        columns = [i for i in validated.broken if self.problem.constraints[i].forbids_losses]
        if columns and failed is not None and isinstance(self.problem, Problem):
            lost = losses(self.problem, self.gains, self._confirmed, failed[1]).any(axis=1)
            out[np.ix_(np.flatnonzero(lost), columns)] = True
        return out

    def _breaking_alike(self, validated: Validated) -> np.ndarray:
        """Return the mask (rows, constraints) of rows that its difference puts beyond a limit; none if it leaves no row.

        All rows make the same flights, so confirmation flights that are harsh for one are so for its neighbors.
        """
        out, held = np.zeros_like(self._struck, dtype=bool), validated.finalists.limits[0]
        for i in validated.broken:
            entry = self.problem.constraints[i]
            if entry.has_tolerance:
                difference = validated.confirmation.excess[1, i] + entry.most - held[validated.tuned, i]
                out[1:, i] = held[1:, i] + difference > entry.most
        left = validated.finalists.feasible & ~out.any(axis=1)
        return out if left[1:].any() else np.zeros_like(out)

    def _judged(self, finals: Finals, raw: FinalFlights) -> tuple[FinalFlights, Validated]:
        while True:
            flown = self._excused(raw)
            look = self._limits.look(flown)
            finalists = self._finalists(look, flown)
            tuned, why = self._choice(finalists, finalists.feasible)
            rows = np.flatnonzero(~raw.complete & unsettled(finalists, tuned))
            if len(rows):
                raw = finals.complete(raw, rows)
            elif (row := self._next_open(look, flown, finalists)) is not None:
                self._limits.fly(self._limits.flier(row), look.excess[row])
            elif self._tails is None or not finalists.feasible[tuned] or not self._tails.judge(tuned):
                break
        settle = None
        if not finalists.feasible[tuned]:
            tuned, settle = self._nearest(look, flown, tuned)
        confirmation = self._confirmation(tuned)
        broken = self._broken(flown, tuned, confirmation) if finalists.feasible[tuned] else np.array([], dtype=int)
        texts = [*self._warnings, *self._open_texts(finalists)]
        further = self._limits.flights
        return raw, Validated(finalists, tuned, why, confirmation, broken, texts, settle, further)

    def _nearest(self, look: Look, flown: FinalFlights, least: int) -> tuple[int, int | None]:
        """Return the row within the limits by value that settles first.

        Its flights come with it; where there is none, the row that is least beyond.
        """
        # Held-out flights settle no limit on a rare event.
        rare = np.zeros_like(self._struck) if self._tails is None else self._tails.excess
        out = np.any(self._struck + rare > 0.0, axis=1)
        rows = (1 + np.flatnonzero(~out[1:])).tolist()
        flights = {row: self._limits.flights_to_settle(look, flown, row) for row in rows}
        settled = {row: count for row, count in flights.items() if count is not None}
        return min(settled.items(), key=lambda entry: entry[1]) if settled else (least, None)

    def _excused(self, flown: FinalFlights) -> FinalFlights:
        air = air_of_finals(flown, self.gains, self._flown)
        self._warn_of_air(air, self._flown)
        return excused_finals(flown, air)

    def _finalists(self, look: Look, flown: FinalFlights) -> Finalists:
        excess = look.excess + self._struck
        if self._tails is not None:
            excess = np.maximum(excess, self._tails.excess)
        return judge(flown, self._seen, self._limits.shown(look, flown), self._without_automatic(excess, flown))

    def _without_automatic(self, excess: np.ndarray, flown: FinalFlights) -> np.ndarray:
        """Return the excess, without automatic limits where these alone decide.

        They keep out all that keep the study's own limits there.
        """
        automatic = np.array([bool(entry.floor) for entry in self.problem.constraints], dtype=bool)
        required = np.all(flown.evaluation.violations[:, len(automatic) :] <= 0.0, axis=1)
        by_own = np.all(excess[:, ~automatic] <= 0.0, axis=1) & required
        if np.any(np.all(excess <= 0.0, axis=1) & required) or not by_own.any():
            return excess
        return np.where(automatic, 0.0, excess)

    def _choice(self, finalists: Finalists, feasible: np.ndarray) -> tuple[int, str]:
        values, rows = finalists.evaluation.values, 1 + np.flatnonzero(feasible[1:])
        same = np.array_equal(feasible, finalists.feasible)
        front = np.flatnonzero(finalists.non_dominated) if same else rows[non_dominated(values[rows])]
        default = Default(bool(feasible[0]), self._worst, self.study.table.relevant)
        excess = relative_excess(self.problem.constraints, finalists.excess)
        return choose_finalist(self.study, values, default, front, excess, self.names)

    def _next_open(self, look: Look, flown: FinalFlights, finalists: Finalists) -> int | None:
        """Return the row whose limits decide the answer: it would be recommended, or best in an objective, if it kept them."""
        values, matters = finalists.evaluation.values, ~finalists.feasible & ~self._struck.any(axis=1)
        is_alone = values.shape[1] == 1 and bool(finalists.feasible[1:].any())
        if is_alone:
            best = values[finalists.feasible].min()
            matters &= values[:, 0] < best - NEGLIGIBLE_SHARE * self.study.table.relevant * abs(best)
        is_open = matters & look.is_open
        likely = is_open & self._limits.may_settle(look, flown)
        # Rows that the last look would hardly settle spend the flights of those behind them.
        if likely.any() or finalists.feasible[1:].any():
            is_open = likely
        if is_alone and not is_open.any():
            # All rows fly the same flights: one that flies on shows by how much these are too harsh for all.
            is_open = matters & look.is_possible & self._limits.may_settle(look, flown, STANDARD_ERROR)
        if not is_open.any():
            return None
        hoped = finalists.feasible | is_open
        rows = np.flatnonzero(hoped)
        named = [self._choice(finalists, hoped)[0], *[int(rows[first_smallest(column)]) for column in values[rows].T]]
        return next((row for row in named if is_open[row]), None)

    def _confirmation(self, tuned: int) -> Evaluation:
        made = self.problem.evaluate_gains(
            self.gains[[0, tuned]], self._confirmed, self._say, fly_all=True, complete=True
        )
        if made.failed is None:
            return made
        air = air_losses(self.problem, self.gains, self._confirmed, np.all(made.failed, axis=0))
        self._warn_of_air(air, self._confirmed)
        return excused_evaluation(self.problem, made, air)

    def _broken(self, flown: FinalFlights, tuned: int, confirmation: Evaluation) -> np.ndarray:
        """Return the constraints that a row breaks on confirmation flights.

        It breaks them by their value, and by the interval of all its flights together.
        """
        broken = [
            i
            for i, entry in enumerate(self.problem.constraints)
            if confirmation.excess[1, i] > 0.0 and entry.is_flown
            if self._is_refuted(flown, tuned, i, confirmation)
        ]
        return np.array(broken, dtype=int)

    def _is_refuted(self, flown: FinalFlights, tuned: int, i: int, confirmation: Evaluation) -> bool:
        """Return True for a row whose flights together break a constraint.

        Their interval counts, and the row flies on while their value keeps the limit.
        """
        entry, fresh = self.problem.constraints[i], (confirmation.scores[1], confirmation.origin)
        while True:
            confidence = self._limits.confidence_of(entry, tuned)
            value, _, upper = self._limits.interval(*self._limits.samples(flown, tuned, fresh), i, confidence)
            if upper <= entry.most:
                return False
            excess = confirmation.excess[1, : len(self.problem.constraints)]
            if value > entry.most or not self._limits.fly(tuned, excess, is_recommended=True):
                return True

    def _warn_of_air(self, air: np.ndarray, flown: tuple) -> None:
        for lost in named_losses(self.problem, self.gains[0], flown, air, "") if air.any() else []:
            self._warnings[
                f'Flight {lost.name} of scenario "{lost.scenario}" is lost by the default and by all {len(self.gains) - 1} '
                "finalists: the air loses it, and it counts for no gains."
            ] = None

    def _open_texts(self, finalists: Finalists) -> list[str]:
        """Return a sentence on further flights and their result; none where no limit was open."""
        parts = [
            f"{self.names[row]} {'keeps' if finalists.feasible[row] else 'does not surely keep'} every limit by {count:,} flights"
            for row, count in self._limits.looked_at().items()
        ]
        if not parts:
            return []
        made = f"{self._limits.flights:,} further held-out flights"
        return [f"Intervals reached beyond a limit, so {made} were made: {'; '.join(parts)}."]


def unsettled(finalists: Finalists, tuned: int) -> np.ndarray:
    """Return a mask (rows,) of those that need all flights: the recommended one, and those short of confidence alone."""
    lacking = ~finalists.feasible & np.all(finalists.evaluation.violations <= 0.0, axis=1)
    return lacking | (np.arange(len(lacking)) == tuned)
