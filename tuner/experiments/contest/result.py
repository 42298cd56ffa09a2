"""All that a contest found."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tuner.documents.contest_document import BoundRow, ClaimRow, PublishedRow, RungRow, StepCost
from tuner.experiments.contest.comparison import Comparison, compare_all
from tuner.experiments.contest.cost import step_cost
from tuner.experiments.contest.flying import ContestPoint, Flown
from tuner.experiments.contest.fronts import Best, Front, Volumes, best_under, front_of, volumes_of
from tuner.experiments.contest.judging import judge_claims, judge_published
from tuner.experiments.contest.tuning import TunedContender
from tuner.experiments.tuning.bounds import on_bounds
from tuner.study.contest import Contest


@dataclass(frozen=True)
class Result:
    """A contest with its contenders' gains, flights and results; lists run over the contenders.

    Attributes:
        flown: The points compared.
        flights: Number of flights of all searches and of the comparison.
        fronts: Fronts, empty where no contender was tuned.
        volumes: Hypervolumes, None where no contender was tuned.
        best_under: Best points under levels, empty where no contender was tuned.
        rungs: Contenders of every rung, empty without halving.
    """

    contest: Contest
    prepared: list[TunedContender]
    flown: Flown
    flights: int
    comparison: Comparison
    fronts: list[Front]
    volumes: Volumes | None
    best_under: list[Best]
    published: list[PublishedRow]
    claims: list[ClaimRow]
    costs: list[StepCost]
    bounds: list[list[BoundRow]]
    seconds: float
    rungs: list[RungRow]

    @cached_property
    def names(self) -> list[str]:
        """Names of the contenders."""
        return [contender.name for contender in self.contest.contenders]

    @property
    def entries(self) -> list[ContestPoint]:
        """The points compared."""
        return [entrant.entry for entrant in self.prepared]


def groups_of(prepared: list[TunedContender]) -> list[list[ContestPoint]]:
    """Return the points to fly: those compared, then the front of each contender."""
    return [[entrant.entry for entrant in prepared], *[entrant.offered or [] for entrant in prepared]]


def judge_contest(
    contest: Contest, prepared: list[TunedContender], groups: list[Flown], seconds: float, rungs: list[RungRow]
) -> Result:
    """Work out everything that follows from the flights of `groups_of`."""
    flown, *behind = groups
    comparison = compare_all(flown, contest.quantities, contest.seed, contest.base.table.relevant)
    objectives, systems = contest.base.objectives, [contender.study.system for contender in contest.contenders]
    fronts = (
        _fronts(contest, prepared, flown, behind) if any(entrant.offered is not None for entrant in prepared) else []
    )
    return Result(
        contest=contest,
        prepared=prepared,
        flown=flown,
        flights=sum(entrant.flights for entrant in prepared)
        + sum(row.flights for row in rungs if not row.goes_on)
        + sum(group.failed.size for group in groups),
        comparison=comparison,
        fronts=fronts,
        volumes=volumes_of(fronts, objectives, flown.origin, contest.seed, contest.base.table.relevant)
        if fronts
        else None,
        best_under=best_under(fronts, len(objectives)) if fronts else [],
        published=judge_published(contest, flown, comparison),
        claims=judge_claims(contest, comparison, bool(fronts)),
        costs=[step_cost(system) for system in systems],
        bounds=[
            on_bounds(entrant.contender.study, entrant.entry.row, np.array([entry.row for entry in entrant.offered]))
            if entrant.offered is not None
            else []
            for entrant in prepared
        ],
        seconds=seconds,
        rungs=rungs,
    )


def _fronts(contest: Contest, prepared: list[TunedContender], flown: Flown, behind: list[Flown]) -> list[Front]:
    """Return the fronts of all; who has none of its own is one point among those of the others."""
    alone = [Flown(flown.scores[[k]], flown.failed[[k]], flown.origin) for k in range(len(prepared))]
    return [
        front_of(contest, [entrant.entry], single)
        if entrant.offered is None
        else front_of(contest, entrant.offered, group)
        for entrant, single, group in zip(prepared, alone, behind, strict=True)
    ]
