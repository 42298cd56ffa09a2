"""Fresh flights of the points that stand at a limit: the distance inside it that a search has to keep.

A search keeps a limit by the value of few flights, which all candidates share, and the held-out check by the end of an interval
over many. Those few may be harsher or milder than most, and no resample of them says which: of 20 studies with a limit that
binds, four ended without gains or 7 to 193 % behind. So some points of the front at a limit make further flights of the search's
stream, which neither the held-out check nor the confirmation sees, and the search looks for points that much further inside.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from objectives.evaluator import Evaluation, Evaluator
from objectives.problem import FlightBatch, Problem
from plant.quadrotor.scenarios import HELD_OUT, SEARCH
from plant.ties import first_smallest, increasing_order
from tuner.experiments.tuning.active_limits import BackOff, shifted_excess, widths
from tuner.experiments.tuning.problem import batches
from tuner.search.front import feasible_front, select_subset
from tuner.study.searched import SearchedStudy

N_TIMES = 4
"""Fresh flights of a point, in those of the search; the held-out check's at most."""
MAX_WATCHED_POINTS = 3
"""Points of a front that make them at a time."""
N_LATE_TIMES = 4
"""Fresh flights of a point late in a search of one objective, in those of the held-out check.

Of a hover with a limit of 0.02, 32 flights put the search 0.0021 outside of it, 1,024 put it 0.0011, and held-out ones 0.0012.
"""
SETTLED_WIDTH = 0.5
"""Share of a half-width that is left at four times the held-out flights, by which most points at a limit are decided."""
NEAR = 0.1
"""Share of a limit from which on a point stands at it: an interval of four flights may be next to nothing."""


class Fresh(NamedTuple):
    """Fresh flights of a candidate: excess (limits,), and half-widths (limits,) of intervals over held-out flights.

    is_late: whether it made `N_LATE_TIMES` of them.
    """

    excess: np.ndarray
    width: np.ndarray
    is_late: bool


class LimitWatch:
    """The back-off of a search from its limits.

    Args:
        problem: Makes the flights; another program's trials are not asked for more.
        study: Its limits and numbers of flights.
        on_flights_done: Called with n as n more flights have ended.
    """

    def __init__(
        self, problem: Evaluator, study: SearchedStudy, on_flights_done: Callable[[int], None] | None = None
    ) -> None:
        self.problem, self.study, self.on_flights_done = problem, study, on_flights_done
        self._limited = [i for i, entry in enumerate(problem.constraints) if entry.has_tolerance]
        self._fresh: dict[int, Fresh] = {}
        held_out = batches(study, HELD_OUT)
        pairs = list(zip(batches(study, SEARCH), held_out, strict=True))
        self._early = fresh_batches((batch, min(N_TIMES * batch.count, held.count)) for batch, held in pairs)
        self._late = fresh_batches((batch, N_LATE_TIMES * held.count) for batch, held in pairs)
        self._held_out = {batch.spec.name: batch.count for batch in held_out}

    @property
    def has_flown(self) -> bool:
        """Whether any point made fresh flights."""
        return bool(self._fresh)

    def back_off(self, evaluation: Evaluation, candidates: np.ndarray) -> BackOff:
        """Return the back-off so far, by late flights where there are any.

        evaluation: of candidates (n,), increasing numbers.
        """
        limits = self.problem.constraints
        back_off = BackOff(np.full(len(limits), np.nan), np.full(len(limits), np.nan))
        fresh_of = {number: fresh for number, fresh in self._fresh.items() if number in candidates}
        is_late = any(fresh.is_late for fresh in fresh_of.values())
        watched = np.array([number for number, fresh in fresh_of.items() if fresh.is_late == is_late], dtype=int)
        if not len(watched):
            return back_off
        excess = np.array([self._fresh[number].excess for number in watched.tolist()])
        width = np.array([self._fresh[number].width for number in watched.tolist()])
        before = evaluation.excess[np.searchsorted(candidates, watched), : len(limits)]
        for i in self._limited:
            upper = excess[:, i] + SETTLED_WIDTH * width[:, i]
            # What flights err about a limit grows with its quantity, so points at the limit that will be judged by count.
            near = increasing_order(np.abs(upper))[: most_watched(is_late)]
            scale = scales(limits[i].most, before[near, i], upper[near])
            shift = np.where(np.isnan(scale), upper[near] - before[near, i], limits[i].most * (1.0 - scale))
            back_off.shift[i] = np.median(shift)
            back_off.width[i] = np.median(width[near, i] * np.where(np.isnan(scale), 1.0, scale))
        back_off.shift[back_off.width <= 0.0] = np.nan
        back_off.width[back_off.width <= 0.0] = np.nan
        return back_off

    def measure(
        self, evaluation: Evaluation, points: np.ndarray, candidates: np.ndarray, is_late: bool = False
    ) -> None:
        """Fly the front's points at a limit on fresh flights.

        points (n, d), candidates (n,): of the evaluation; those that made these flights make no more.
        is_late: whether a single point makes more of them, if there is one objective.
        """
        if not self._limited or not isinstance(self.problem, Problem):
            return
        is_late = is_late and has_one(evaluation)
        chosen = self._at_limits(evaluation, self.back_off(evaluation, candidates))
        if len(chosen):
            values = evaluation.values[chosen]
            chosen = chosen[select_subset(values, values.max(axis=0), most_watched(is_late))]
        made = [number for number, fresh in self._fresh.items() if fresh.is_late >= is_late]
        chosen = chosen[~np.isin(candidates[chosen], made)]
        if not len(chosen):
            return
        flown = self._late if is_late else self._early
        fresh = self.problem.evaluate(points[chosen], flown, self.on_flights_done, fly_all=True)
        half = np.array(
            [
                widths(fresh, self.problem.constraints, i, self.study.seed)[1]
                for i in range(len(self.problem.constraints))
            ]
        )
        half *= np.sqrt([[self._share(flown, entry.objective.scenario)] for entry in self.problem.constraints])
        for row, number in enumerate(candidates[chosen].tolist()):
            self._fresh[number] = Fresh(fresh.excess[row, : len(half)], half[:, row], is_late)

    def _at_limits(self, evaluation: Evaluation, back_off: BackOff) -> np.ndarray:
        """Return the rows of the front whose interval reaches beyond a limit."""
        excess = shifted_excess(evaluation, back_off)
        front = feasible_front(evaluation.values, np.maximum(excess, 0.0))
        front = front[evaluation.complete[front]]
        if not len(front):
            keeps = ~np.any(evaluation.violations[:, len(back_off.shift) :] > 0.0, axis=1) & evaluation.complete
            rows = np.flatnonzero(keeps)
            return rows[[first_smallest(excess[rows].max(axis=1))]] if len(rows) else rows
        reach = np.zeros((len(front), len(self.problem.constraints)))
        for i in self._limited:
            above = widths(evaluation, self.problem.constraints, i, self.study.seed, front)[1]
            above = np.maximum(above, NEAR * abs(self.problem.constraints[i].most))
            reach[:, i] = above if np.isnan(back_off.width[i]) else back_off.width[i]
        return front[np.any(excess[front, : reach.shape[1]][:, self._limited] + reach[:, self._limited] > 0.0, axis=1)]

    def _share(self, flown: tuple[FlightBatch, ...], scenario: str | None) -> float:
        """Return the ratio of the flights flown to held-out ones."""
        counted = [batch for batch in flown if scenario in (None, batch.spec.name)]
        made = sum(batch.count - batch.start for batch in counted)
        return made / sum(self._held_out[batch.spec.name] for batch in counted)


def has_one(evaluation: Evaluation) -> bool:
    """Return True for the evaluation of one objective."""
    return evaluation.values.shape[1] == 1


def most_watched(is_late: bool) -> int:
    """Return the number of points that count: late ones make the same many flights, so they err alike."""
    return 1 if is_late else MAX_WATCHED_POINTS


def fresh_batches(counts: Iterable[tuple[FlightBatch, int]]) -> tuple[FlightBatch, ...]:
    """Return so many flights behind those of each batch."""
    return tuple(replace(batch, start=batch.count, count=batch.count + count) for batch, count in counts)


def scales(most: float, before: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Return the ratios (n,) of the search's value to the upper end.

    most: the limit; before, upper (n,): the excess of both over it. NaN where one of the three is not positive.
    """
    searched, fresh = most + before, most + upper
    is_positive = (most > 0.0) & (searched > 0.0) & (fresh > 0.0)
    return np.where(is_positive, searched / np.where(is_positive, fresh, 1.0), np.nan)
