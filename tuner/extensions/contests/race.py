"""Successive halving of a contest's searches: all go on to a rung, and the contenders with the better fronts beyond it.

Fronts are those of the search flights, which are the same for all, in one common box: up to 1.1 times the nadir of all fronts of
the rung. A contender without a feasible candidate stands behind those with one, by its least violation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tuner.documents.comparison_document import RungRow
from tuner.experiments.tuning.run import TuningRun
from tuner.experiments.tuning.search import search
from tuner.extensions.contests.study import Contest
from tuner.extensions.contests.tuning import PreparedContender, contender_study, place_of
from tuner.search.constraint_ranking import TotalViolation
from tuner.search.convergence import StoppingRule
from tuner.search.front import hypervolume
from tuner.search.loop import Generation, archive
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.store.manifest import FILE as MANIFEST
from tuner.study.comparison import Contender

LEAD = 0.1
"""Share of an objective by which a front is ahead where the other's search is not carried on."""

NO_FRONT = np.empty((0, 1))


class RungRun(TuningRun):
    """The search of a contender up to a rung, without a conclusion; a longer one in its folder replays its flights."""

    generations: int
    done: list[Generation]

    def fly(self) -> Any:
        """Search for so many generations."""
        algorithm, _ = self.algorithm()
        rule = StoppingRule(self.generations)
        self.done = search(self.problem, self.study, self.folder, self.watcher, algorithm, rule, self.clock)

    def write(self, result: object) -> None:
        """Write nothing more than the search has."""


@dataclass(frozen=True)
class Standing:
    """A contender at a rung.

    Attributes:
        front: Objectives (n, m) of its feasible, non-dominated candidates.
        violations: Violations (k, c) of all its candidates.
        flights: Flights of its search so far.
    """

    contender: Contender
    generations: int
    front: np.ndarray
    violations: np.ndarray
    flights: int


def raced(contest: Contest, folder: Folder, watcher: Watcher, threads: int | None) -> tuple[Contest, list[RungRow]]:
    """Return a contest of the finalists, and the contenders of every rung; without halving all are finalists."""
    if contest.halving is None:
        return contest, []
    left, rows = list(contest.contenders), list[RungRow]()
    rungs = contest.halving.rungs(len(left))
    sizes = [*[rung.contenders for rung in rungs[1:]], contest.halving.finalists]
    for number, (rung, goes_on) in enumerate(zip(rungs, sizes, strict=True), start=1):
        standings = []
        for contender in left:
            watcher.on_contender(f"{contender.name}, rung {number}", len(standings) + 1, len(left))
            generations = contest.halving.generations(rung, contender.study.search.generations)
            standings.append(stand(contest, contender, generations, folder, watcher, threads))
        values, broken = shares(standings), least_violations(standings)
        order = sorted(range(len(left)), key=lambda i: (-values[i], broken[i], i))
        remaining = order[:goes_on]
        if number == len(rungs) and not _names_contenders(contest):
            remaining = contested([standings[i].front for i in remaining], remaining)
        remaining.sort()
        rows += [rung_row(number, standings[i], values[i], i in remaining) for i in range(len(left))]
        left = [left[i] for i in remaining]
    return replace(contest, contenders=tuple(left)), rows


def keep_feasible(
    contest: Contest, tuned: Sequence[PreparedContender], number: int
) -> tuple[list[PreparedContender], list[RungRow]]:
    """Return the finalists within their limits; all if none, or all, are.

    The whole searches are then a rung more, of this number, from which the others do not go on. Without halving a contest
    compares what it names.
    """
    feasible = [entrant for entrant in tuned if entrant.feasible and entrant.offered]
    if contest.halving is None or _names_contenders(contest) or len(feasible) in (0, len(tuned)):
        return list(tuned), []
    fronts = {entrant.contender.name: _picked(entrant) for entrant in feasible}
    nadir = np.concatenate(list(fronts.values())).max(axis=0)
    rows = [
        RungRow(
            rung=number,
            contender=entrant.contender.name,
            generations=entrant.contender.study.search.generations,
            flights=entrant.search_flights,
            feasible=entrant.contender.name in fronts,
            share=hypervolume(fronts.get(entrant.contender.name, NO_FRONT), nadir),
            goes_on=entrant.contender.name in fronts,
        )
        for entrant in tuned
    ]
    return feasible, rows


def _names_contenders(contest: Contest) -> bool:
    """Return True where claims or printed numbers are of contenders."""
    return bool(contest.claims or contest.published)


def _picked(entrant: PreparedContender) -> np.ndarray:
    """Return the held-out front (n, m) of a contender."""
    return np.array([point.picked for point in entrant.offered or []])


def contested(fronts: Sequence[np.ndarray], rows: Sequence[int]) -> list[int]:
    """Return the finalists between which a comparison can decide.

    Args:
        fronts: Objectives (n, m) of each finalist, the best first.
        rows: Rows of the finalists.
    """
    first = fronts[0]
    if not len(first):
        return list(rows)
    return [row for row, front in zip(rows, fronts, strict=True) if not is_far_ahead(first, front)]


def is_far_ahead(front: np.ndarray, other: np.ndarray) -> bool:
    """Return True for a front ahead of another by `LEAD` everywhere.

    Each point of the other (n, m) is worse than one of the front in every objective. A front without points is behind.
    """
    worse = other[:, None, :] - front[None, :, :] > LEAD * np.abs(other[:, None, :])
    return bool(worse.all(axis=-1).any(axis=-1).all(axis=-1))


def stand(
    contest: Contest, contender: Contender, generations: int, folder: Folder, watcher: Watcher, threads: int | None
) -> Standing:
    """Search a contender's gains up to a rung; return its standing."""
    study, place = contender_study(contest, contender, folder), place_of(contender)
    run = RungRun(study, Folder.open_or_create(folder.path / place), watcher, threads=threads)
    run.generations = generations
    run.carry_out()
    folder.written(f"{place}/{MANIFEST}")
    return standing_of(contender, run.done)


def standing_of(contender: Contender, generations: list[Generation]) -> Standing:
    """Return the standing of a contender after generations of its search."""
    tried = archive(generations)
    front = tried.values[tried.front()]
    return Standing(contender, len(generations), front, tried.violations, generations[-1].flights)


def shares(standings: Sequence[Standing]) -> list[float]:
    """Return the share of the common box that each front dominates; 0 without a feasible candidate."""
    fronts = [standing.front for standing in standings if len(standing.front)]
    if not fronts:
        return [0.0] * len(standings)
    nadir = np.concatenate(fronts).max(axis=0)
    return [hypervolume(standing.front, nadir) for standing in standings]


def least_violations(standings: Sequence[Standing]) -> list[float]:
    """Return the least total violation of each contender in common units."""
    total = TotalViolation(standings[0].violations.shape[1])
    totals = total.of(np.concatenate([standing.violations for standing in standings]))
    ends = np.cumsum([len(standing.violations) for standing in standings])
    return [float(part.min(axis=0)) for part in np.split(totals, ends[:-1])]


def rung_row(number: int, standing: Standing, share: float, goes_on: bool) -> RungRow:
    """Return the row of a contender at a rung."""
    return RungRow(
        rung=number,
        contender=standing.contender.name,
        generations=standing.generations,
        flights=standing.flights,
        feasible=len(standing.front) > 0,
        share=share,
        goes_on=goes_on,
    )
