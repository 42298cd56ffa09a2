"""A contest, checked and ready to run: what its contenders are judged by, and how their searches race.

In successive halving searches of many contenders go on in rungs, from each of which the better part goes on: K. Jamieson,
A. Talwalkar, "Non-stochastic best arm identification and hyperparameter optimization", AISTATS 2016, arXiv:1502.07943.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import ceil
from typing import Any, ClassVar

from objectives.metrics import MetricAddress
from objectives.problem import Objective
from objectives.risk import Risk
from plant.texts import PlainTable
from tuner.study.comparison import ComparisonStudy


@dataclass(frozen=True)
class Published:
    """A printed number to be judged: `value` (SI, rad) of a metric in a scenario, printed of each of `contenders`.

    fitted: the study was set to meet it, so that meeting it says nothing.
    """

    contenders: tuple[str, ...]
    metric: MetricAddress
    scenario: str
    value: float
    source: str
    fitted: bool = False

    @property
    def objective(self) -> Objective:
        """The quantity whose flights it is compared with."""
        return Objective(self.metric, Risk("mean"), self.scenario)


@dataclass(frozen=True)
class Claim:
    """A statement to be judged: `better` is lower than each of `than` in each of `objectives`."""

    better: str
    than: tuple[str, ...]
    objectives: tuple[Objective, ...]
    text: str


@dataclass(frozen=True)
class Rung:
    """Searches of so many contenders, up to a share of their generations."""

    contenders: int
    share: float


@dataclass(frozen=True)
class HalvingSchedule:
    """Settings of successive halving.

    Attributes:
        factor: Number of contenders of which one goes on, to a search that is as many times longer.
        finalists: Contenders whose searches are carried to their end.
        least: Smallest number of generations of a rung.
    """

    factor: int
    finalists: int
    least: int

    def rungs(self, contenders: int) -> tuple[Rung, ...]:
        """Return the rungs before the finalists' searches are carried to their end."""
        sizes: list[int] = []
        while contenders > self.finalists:
            sizes.append(contenders)
            contenders = max(ceil(contenders / self.factor), self.finalists)
        return tuple(Rung(size, float(self.factor) ** (i - len(sizes))) for i, size in enumerate(sizes))

    def generations(self, rung: Rung, generations: int) -> int:
        """Return the generations of a rung, of a search with so many."""
        return min(max(ceil(generations * rung.share), self.least), generations)

    def flights_at_most(self, searches: list[tuple[int, int]]) -> int:
        """Return the most flights of all rungs and finalists.

        searches: of each contender the generations, and the most flights of one.
        """
        rungs, total = self.rungs(len(searches)), 0
        for i, (generations, flights) in enumerate(sorted(searches, key=lambda search: -search[0] * search[1])):
            reached = [self.generations(rung, generations) for rung in rungs if i < rung.contenders]
            total += flights * (generations if i < self.finalists else max(reached, default=generations))
        return total


@dataclass(frozen=True)
class Contest(ComparisonStudy):
    """Contenders with what they are judged by; each one's point is picked on held-out scenarios, which are others.

    Attributes:
        table: Merged content of the file, overrides included.
        halving: Successive halving of the searches, None where each is carried to its end.
    """

    kind: ClassVar[str] = "contest"
    generations: ClassVar[None] = None
    published: tuple[Published, ...]
    claims: tuple[Claim, ...]
    table: PlainTable
    halving: HalvingSchedule | None = None

    @property
    def content(self) -> PlainTable:
        """The content of the file, see `table`."""
        return self.table

    @property
    def deciding(self) -> list[Any]:
        """Printed numbers, claims and halving."""
        judged = [self.table.get(key) for key in ("published", "claim")]
        return [judged, *([asdict(self.halving)] if self.halving else [])]

    @property
    def halving_texts(self) -> list[str]:
        """Sentences on the race of its searches, none without one."""
        if self.halving is None:
            return []
        rungs = self.halving.rungs(len(self.contenders))
        longest = max(contender.study.search.generations for contender in self.contenders)
        steps = [f"{rung.contenders} to {self.halving.generations(rung, longest)} generations" for rung in rungs]
        texts = [f"Successive halving: {', '.join(steps)}, {self.halving.finalists} to {longest}."]
        if not all(contender.study.search.starts for contender in self.contenders):
            texts.append(
                "Not every search has starts: after few generations fronts predict little of a search's end; name some in "
                "search.starts, or raise halving.least."
            )
        return texts

    @property
    def further_objectives(self) -> Sequence[tuple[str, Sequence[Objective]]]:
        """Objectives that printed numbers and claims ask for."""
        return (
            ("published", [cell.objective for cell in self.published]),
            ("claimed", [objective for claim in self.claims for objective in claim.objectives]),
        )
