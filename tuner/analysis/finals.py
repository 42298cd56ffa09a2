"""Further held-out flights of the finalists, only where they decide something.

All finalists meet the same scenarios, so a part of the flights often tells which of two is better. Everyone makes the first
quarter. A finalist makes no more where at least LEVEL of the bootstrap resamples of that quarter agree on its place: which limits
it keeps, whom it dominates, who dominates it, and that it is not the one to recommend. The recommended point, the default and
all whose place is open make all flights. As the races of a search (`objectives.racing`), here among equals.

No resample holds a loss that was not seen. A limit on a share is settled by its Clopper-Pearson interval at LEVEL; and as 0 of 64
losses leave room for 7 %, a finalist that stopped counts as one that may yet lose a flight, which can only make it worse: the
choice must be the same with all of them, without any one of them and without all of them. Those on whom it depends make their
flights.
"""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

import numpy as np

from objectives.flown_system import FlightBatch
from objectives.problem import Evaluator, Problem
from objectives.requirements import known_values, requirement_excess
from objectives.risk import replicates_on
from plant.seeds import generator
from tuner.analysis.final_flights import FRONT_REPLICATES, FinalFlights, dominates

Array = np.ndarray
# Part of the flights that everyone makes; how many they are in a scenario at least for anything to be decided by them; share of
# the resamples that decides.
SHARE, MIN_FLIGHTS, LEVEL = 0.25, 32, 0.99
# Random sets of those that stopped without which the choice must be the same, and the share of those that is in each.
TRIED, LOST = 32, 0.25
MOVED = (0.025, 0.975)

Choose = Callable[[Array, Array], int]
"""Objectives (rows, objectives) and mask (rows,) of those that keep all limits -> the row to recommend."""


class Finals:
    """Flies finalists, gains (rows, gains) with the default first. choose: picks the row to recommend; root: of resamples."""

    def __init__(
        self,
        problem: Evaluator,
        gains: Array,
        batches: tuple[FlightBatch, ...],
        choose: Choose,
        root: int,
        on_flights_done: Callable[[int], None] | None = None,
    ) -> None:
        self._problem, self._gains, self._batches, self._choose = problem, gains, batches, choose
        self._root, self._on_flights_done = root, on_flights_done
        self._early = early_counts(batches)

    def fly(self) -> FinalFlights:
        """Return the flights of everyone, as far as they decide something."""
        begin, flights = perf_counter(), self.fly_early()
        if flights.early.all():
            return replace(flights, complete=np.ones(len(self._gains), dtype=bool), seconds=perf_counter() - begin)
        flights = self.complete(flights, np.flatnonzero(~decided(flights, self._choose)))
        while len(rows := decisive(flights, self._choose)):
            flights = self.complete(flights, rows)
        stopped = int(np.sum(~flights.complete, axis=0))
        self._problem.spare(stopped * int(np.sum(~flights.early, axis=0)), self._on_flights_done)
        return replace(flights, seconds=perf_counter() - begin)

    def fly_early(self) -> FinalFlights:
        """Return the flights that everyone makes."""
        flights = self._unflown()
        self._fly(flights, np.arange(len(self._gains)), [0] * len(self._batches), self._early)
        return flights

    def complete(self, flights: FinalFlights, rows: Array) -> FinalFlights:
        """Return flights with all of those that some rows had left out."""
        self._fly(flights, rows, self._early, [batch.count for batch in self._batches])
        complete = flights.complete.copy()
        complete[rows] = True
        for name in np.unique(flights.origin):
            made, rest = (flights.origin == name) & flights.early, (flights.origin == name) & ~flights.early
            mean = flights.scores[..., made].mean(axis=-1, keepdims=True)
            flights.scores[..., rest] = np.where(complete[:, None, None], flights.scores[..., rest], mean)
        return replace(flights, complete=complete)

    def _unflown(self) -> FinalFlights:
        rows, counts = len(self._gains), [batch.count for batch in self._batches]
        parts = zip(self._batches, self._early, strict=True)
        return FinalFlights(
            self._problem,
            self._root,
            scores=np.zeros((rows, len(self._problem.quantities), sum(counts))),
            failed=np.zeros((rows, sum(counts)), dtype=bool),
            origin=np.repeat([batch.spec.name for batch in self._batches], counts),
            requirements=known_values(self._problem.screens, self._gains, complete=True),
            early=np.concatenate([np.arange(batch.count) < early for batch, early in parts]),
            complete=np.zeros(rows, dtype=bool),
        )

    def _fly(self, flights: FinalFlights, rows: Array, first: list[int], last: list[int]) -> None:
        """Have rows make the flights of each batch from `first` to `last`."""
        start, everyone = 0, np.ones(len(rows), dtype=bool)
        for batch, begin, end in zip(self._batches, first, last, strict=True):
            for low, high in ranges(self._problem, batch, begin, end):
                columns = slice(start + low, start + high)
                flights.scores[rows, :, columns], flights.failed[rows, columns] = self._problem.scored(
                    self._gains[rows], everyone, batch, low, high, self._on_flights_done
                )
            start += batch.count


def early_counts(batches: tuple[FlightBatch, ...]) -> list[int]:
    """Return the numbers of flights, by batch, that every finalist makes."""
    enough = all(SHARE * batch.count >= MIN_FLIGHTS for batch in batches)
    return [round(SHARE * batch.count) if enough else batch.count for batch in batches]


def ranges(problem: Evaluator, batch: FlightBatch, begin: int, end: int) -> list[tuple[int, int]]:
    """Return the successive ranges of a batch's flights from `begin` to `end`."""
    chunks = problem.chunks(replace(batch, count=end))
    return [(max(low, begin), high) for low, high in chunks if high > begin]


def draw_ahead(problem: Problem, flown: tuple[FlightBatch, ...], confirmed: tuple[FlightBatch, ...]) -> None:
    """Draw the flights of `Finals` ahead, and those repeated in full batches."""
    for batch, early in zip(flown, early_counts(flown), strict=True):
        for first, last in [*ranges(problem, batch, 0, early), *ranges(problem, batch, early, batch.count)]:
            problem.engine.draw_ahead(batch, first, last)
    for batch in confirmed:
        for first, last in problem.chunks(batch):
            problem.engine.draw_ahead(batch, first, last)


def decided(flights: FinalFlights, choose: Choose) -> Array:
    """Return the mask (rows,) of those that may stop early: never the default, row 0."""
    parts = [flights.seen(i, early=True) for i in range(len(flights.problem.objectives))]
    replicates = np.stack([replicates_on(samples, risk, drawn) for samples, drawn, risk in parts], axis=1)
    keeps, is_open = limits_kept(flights)
    keeping = keeps.mean(axis=1)
    if not np.any(keeping[1:] >= LEVEL):
        return np.zeros(len(keeping), dtype=bool)
    stops = ((keeping >= LEVEL) & ~is_open) | (keeping <= 1.0 - LEVEL)
    stops &= ~contested(replicates, keeping)
    stops &= recommended(replicates, keeps, choose) <= 1.0 - LEVEL
    stops[0] = False
    return stops


def limits_kept(flights: FinalFlights) -> tuple[Array, Array]:
    """Return two masks: all limits satisfied (rows, r) by resample; that share not settled yet (rows,).

    A share that is allowed to be 0 alone is left to `decisive` as long as it is 0: no number of flights would settle it.
    """
    problem, m = flights.problem, len(flights.problem.objectives)
    are_met = np.all(requirement_excess(problem.requirements, flights.requirements) <= 0.0, axis=1)
    keeps, is_open = np.repeat(are_met[:, None], FRONT_REPLICATES, axis=1), np.zeros(len(are_met), dtype=bool)
    for i, entry in enumerate(problem.constraints):
        samples, drawn, risk = flights.seen(m + i, early=True)
        if entry.objective.is_binary:
            low, high = entry.objective.interval(samples, drawn, 2.0 * LEVEL - 1.0)
            keeps &= (low <= entry.most)[:, None]
            is_open |= (low <= entry.most) & (entry.most < high) & (entry.most > 0.0)
        else:
            keeps &= replicates_on(samples, risk, drawn) <= entry.most
    return keeps, is_open


def decisive(flights: FinalFlights, choose: Choose) -> Array:
    """Return the stopped rows (k,) whose further flights decide the choice."""
    problem, m = flights.problem, len(flights.problem.objectives)
    values = np.stack([flights.value(i) for i in range(len(problem.quantities))], axis=1)
    keeps = np.all(requirement_excess(problem.requirements, flights.requirements) <= 0.0, axis=1)
    keeps &= np.all(problem.constraint_excess(values) <= 0.0, axis=1)
    stopped = np.flatnonzero(keeps & ~flights.complete)
    if not len(stopped):
        return stopped
    objectives, rows = np.ascontiguousarray(values[:, :m]), np.arange(len(keeps))
    replicates = np.stack([flights.replicates(i) for i in range(m)], axis=1)
    share = recommended(replicates, np.repeat(keeps[:, None], FRONT_REPLICATES, axis=1), choose)
    first = choose(objectives, keeps)
    depends = (share > 1.0 - LEVEL) | (rows == first)
    depends |= np.array([choose(objectives, keeps & (rows != row)) != first for row in rows])
    # As far as further flights may move a point from the one chosen: the ends of a front say which point is its knee.
    for ends in objectives[first] + np.quantile(replicates - replicates[first], MOVED, axis=-1):
        depends |= np.array(
            [choose(np.where((rows == row)[:, None], ends, objectives), keeps) != first for row in rows]
        )
    if np.any(depends[stopped]):
        return stopped[depends[stopped]]
    for out in _losing(flights, stopped):
        left = keeps & ~out
        alone = choose(objectives, left)
        if alone != first:
            back = {row: choose(objectives, left | (rows == row)) for row in np.flatnonzero(out)}
            # One at a time: with the end of a front in place, the points inside it often decide nothing.
            return np.array(sorted(back, key=lambda row: (back[row] != first, back[row] == alone))[:1])
    return stopped[:0]


def _losing(flights: FinalFlights, stopped: Array) -> Array:
    """Return masks (k, rows) of stopped rows that may yet lose a flight together.

    The first holds all of them, the others are sets at random.
    """
    draw = generator(flights.root, "finals/losing", int(flights.complete.sum(axis=0)))
    some = np.concatenate([np.ones((1, len(stopped)), dtype=bool), draw.random((TRIED, len(stopped))) < LOST])
    out = np.zeros((len(some), len(flights.complete)), dtype=bool)
    out[:, stopped] = some
    return out


def contested(replicates: Array, keeping: Array) -> Array:
    """Return the mask of rows (rows,) with an uncertain dominance: in neither most nor few of the resamples.

    replicates (rows, m, r): objectives; keeping (rows,): share of the resamples in which a row keeps all limits. Who surely is
    dominated, or breaks a limit, has no part in it, nor has the default.
    """
    rows = 1 + np.flatnonzero(keeping[1:] > 1.0 - LEVEL)
    others = replicates[rows]
    share = np.array([dominates(one, others, axis=1).mean(axis=-1) for one in others]).reshape(len(rows), len(rows))
    off = np.any((share >= LEVEL) & (keeping[rows] >= LEVEL)[:, None], axis=0)
    unsure = (share > 1.0 - LEVEL) & (share < LEVEL) & ~off & ~off[:, None]
    flights = np.zeros(len(keeping), dtype=bool)
    flights[rows] = unsure.any(axis=0) | unsure.any(axis=1)
    return flights


def recommended(replicates: Array, keeps: Array, choose: Choose) -> Array:
    """Return the share of the resamples in which each row (rows,) is recommended.

    replicates (rows, m, r): objectives; keeps (rows, r): whether the row keeps all limits there.
    """
    chosen = [choose(np.ascontiguousarray(replicates[..., r]), keeps[:, r]) for r in range(keeps.shape[1])]
    return np.bincount(chosen, minlength=len(keeps)) / keeps.shape[1]
