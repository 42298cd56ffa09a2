"""The held-out flights of the finalists go on only where they decide something.

All finalists meet the same scenarios, so a part of the flights often tells which of two is better. Everyone makes the first
quarter. A finalist makes no more where at least LEVEL of the bootstrap resamples of that quarter agree on its place: which limits
it keeps, whom it dominates, who dominates it, and that it is not the one to recommend. The recommended point, the default and
all whose place is open make all flights. As the races of a search (`objectives.racing`), here among equals.
"""

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

import numpy as np

from objectives.problem import Evaluator, Problem
from objectives.requirements import known_values, known_violations
from objectives.risk import replicates_on
from objectives.system import FlightBatch
from tuner.analysis.final_flights import FinalFlights, dominates

Array = np.ndarray
# Part of the flights that everyone makes; how many they are in a scenario at least for anything to be decided by them; share of
# the resamples that decides.
SHARE, FEWEST, LEVEL = 0.25, 32, 0.99

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
        begin, found = perf_counter(), self._unflown()
        self._fly(found, np.arange(len(self._gains)), [0] * len(self._batches), self._early)
        if found.early.all():
            return replace(found, complete=np.ones(len(self._gains), dtype=bool), seconds=perf_counter() - begin)
        stopped = decided(found, self._choose)
        self._problem.spare(int(stopped.sum(axis=0)) * int(np.sum(~found.early, axis=0)), self._on_flights_done)
        return replace(self.complete(found, np.flatnonzero(~stopped)), seconds=perf_counter() - begin)

    def complete(self, found: FinalFlights, rows: Array) -> FinalFlights:
        """Return flights with all of those that some rows had left out."""
        self._fly(found, rows, self._early, [batch.count for batch in self._batches])
        complete = found.complete.copy()
        complete[rows] = True
        for name in np.unique(found.origin):
            made, rest = (found.origin == name) & found.early, (found.origin == name) & ~found.early
            mean = found.scores[..., made].mean(axis=-1, keepdims=True)
            found.scores[..., rest] = np.where(complete[:, None, None], found.scores[..., rest], mean)
        return replace(found, complete=complete)

    def _unflown(self) -> FinalFlights:
        rows, counts = len(self._gains), [batch.count for batch in self._batches]
        parts = zip(self._batches, self._early, strict=True)
        return FinalFlights(
            self._problem,
            self._root,
            scores=np.zeros((rows, len(self._problem.quantities), sum(counts))),
            failed=np.zeros((rows, sum(counts)), dtype=bool),
            origin=np.repeat([batch.spec.name for batch in self._batches], counts),
            known=known_values(self._problem.screens, self._gains, complete=True),
            early=np.concatenate([np.arange(batch.count) < early for batch, early in parts]),
            complete=np.zeros(rows, dtype=bool),
        )

    def _fly(self, found: FinalFlights, rows: Array, first: list[int], last: list[int]) -> None:
        """Have rows make the flights of each batch from `first` to `last`."""
        start, everyone = 0, np.ones(len(rows), dtype=bool)
        for batch, begin, end in zip(self._batches, first, last, strict=True):
            for low, high in ranges(self._problem, batch, begin, end):
                columns = slice(start + low, start + high)
                found.scores[rows, :, columns], found.failed[rows, columns] = self._problem.scored(
                    self._gains[rows], everyone, batch, low, high, self._on_flights_done
                )
            start += batch.count


def early_counts(batches: tuple[FlightBatch, ...]) -> list[int]:
    """Return how many flights of each batch everyone makes."""
    enough = all(SHARE * batch.count >= FEWEST for batch in batches)
    return [round(SHARE * batch.count) if enough else batch.count for batch in batches]


def ranges(problem: Evaluator, batch: FlightBatch, begin: int, end: int) -> list[tuple[int, int]]:
    """Return the ranges in which the flights of a batch from `begin` to `end` are made, one after the other."""
    chunks = problem.chunks(replace(batch, count=end))
    return [(max(low, begin), high) for low, high in chunks if high > begin]


def draw_ahead(problem: Problem, flown: tuple[FlightBatch, ...], again: tuple[FlightBatch, ...]) -> None:
    """Have what `Finals` flies, and what is flown again in whole batches, drawn beforehand."""
    for batch, early in zip(flown, early_counts(flown), strict=True):
        for first, last in [*ranges(problem, batch, 0, early), *ranges(problem, batch, early, batch.count)]:
            problem.engine.draw_ahead(batch, first, last)
    for batch in again:
        for first, last in problem.chunks(batch):
            problem.engine.draw_ahead(batch, first, last)


def decided(found: FinalFlights, choose: Choose) -> Array:
    """Return who may stop after the flights that everyone made (rows,); never the default, which is the first row."""
    problem, m = found.problem, len(found.problem.objectives)
    parts = [found.seen(i, early=True) for i in range(len(problem.quantities))]
    replicates = np.stack([replicates_on(samples, risk, drawn) for samples, drawn, risk in parts], axis=1)
    most = np.array([entry.most for entry in problem.constraints])
    known = np.all(known_violations(problem.requirements, found.known) <= 0.0, axis=1)
    keeps = np.all(replicates[:, m:] <= most[:, None], axis=1) & known[:, None]
    keeping = keeps.mean(axis=1)
    if not np.any(keeping[1:] >= LEVEL):
        return np.zeros(len(keeping), dtype=bool)
    stops = (keeping >= LEVEL) | (keeping <= 1.0 - LEVEL)
    stops &= ~contested(replicates[:, :m], keeping)
    stops &= recommended(replicates[:, :m], keeps, choose) <= 1.0 - LEVEL
    stops[0] = False
    return stops


def contested(replicates: Array, keeping: Array) -> Array:
    """Return which rows (rows,) dominate another, or are dominated, in some of the resamples but neither in most nor in few.

    replicates (rows, m, r): objectives; keeping (rows,): share of the resamples in which a row keeps all limits. Who surely is
    dominated, or breaks a limit, has no part in it, nor has the default.
    """
    rows = 1 + np.flatnonzero(keeping[1:] > 1.0 - LEVEL)
    others = replicates[rows]
    share = np.array([dominates(one, others, axis=1).mean(axis=-1) for one in others]).reshape(len(rows), len(rows))
    off = np.any((share >= LEVEL) & (keeping[rows] >= LEVEL)[:, None], axis=0)
    unsure = (share > 1.0 - LEVEL) & (share < LEVEL) & ~off & ~off[:, None]
    found = np.zeros(len(keeping), dtype=bool)
    found[rows] = unsure.any(axis=0) | unsure.any(axis=1)
    return found


def recommended(replicates: Array, keeps: Array, choose: Choose) -> Array:
    """Return in which share of the resamples each row (rows,) is the one to recommend.

    replicates (rows, m, r): objectives; keeps (rows, r): whether the row keeps all limits there.
    """
    chosen = [choose(np.ascontiguousarray(replicates[..., r]), keeps[:, r]) for r in range(keeps.shape[1])]
    return np.bincount(chosen, minlength=len(keeps)) / keeps.shape[1]
