"""Successive halving: searches of many contenders go on in rungs, from each of which the better part goes on.

K. Jamieson, A. Talwalkar, "Non-stochastic best arm identification and hyperparameter optimization", AISTATS 2016,
arXiv:1502.07943.
"""

from dataclasses import dataclass
from math import ceil


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
