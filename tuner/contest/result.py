"""All that a contest found."""

from dataclasses import dataclass
from functools import cached_property

from tuner.contest.bounds import OnBound, on_bounds
from tuner.contest.claims import JudgedClaim, judge_claims
from tuner.contest.comparison import Comparison, compare_all
from tuner.contest.contest import Contest
from tuner.contest.cost import Cost, cost_of
from tuner.contest.flying import Entry, Flown
from tuner.contest.fronts import Best, Front, Volumes, best_under, volumes_of
from tuner.contest.given import given_front
from tuner.contest.published import Cell, judge_cells
from tuner.contest.tuning import Prepared


@dataclass(frozen=True)
class Result:
    """A contest with its contenders' gains, flights and what follows from them; lists run over the contenders.

    fronts, best_under: empty, and volumes None, where no contender was tuned.
    """

    contest: Contest
    prepared: list[Prepared]
    entries: list[Entry]
    flown: Flown
    comparison: Comparison
    fronts: list[Front]
    volumes: Volumes | None
    best_under: list[Best]
    cells: list[Cell]
    claims: list[JudgedClaim]
    costs: list[Cost]
    bounds: list[list[OnBound]]
    seconds: float

    @cached_property
    def names(self) -> list[str]:
        """Names of the contenders."""
        return [contender.name for contender in self.contest.contenders]

    @property
    def flights(self) -> int:
        """Number of flights of all searches and of the comparison."""
        return sum(entry.flights for entry in self.prepared) + self.flown.failed.size


def judge_contest(
    contest: Contest, prepared: list[Prepared], entries: list[Entry], flown: Flown, seconds: float
) -> Result:
    """Work out everything that follows from the flights."""
    comparison = compare_all(flown, contest.quantities, contest.seed)
    objectives = contest.base.objectives
    fronts = (
        [
            given_front(contest, k, flown, comparison) if own.front is None else own.front
            for k, own in enumerate(prepared)
        ]
        if any(own.front is not None for own in prepared)
        else []
    )
    return Result(
        contest=contest,
        prepared=prepared,
        entries=entries,
        flown=flown,
        comparison=comparison,
        fronts=fronts,
        volumes=volumes_of(fronts, objectives, contest.seed) if fronts else None,
        best_under=best_under(fronts, len(objectives)) if fronts else [],
        cells=judge_cells(contest, flown, comparison),
        claims=judge_claims(contest, comparison),
        costs=[cost_of(contender.study.system.cascade) for contender in contest.contenders],
        bounds=[
            on_bounds(own.contender.study, own.row, own.front.gains) if own.front is not None else []
            for own in prepared
        ],
        seconds=seconds,
    )
