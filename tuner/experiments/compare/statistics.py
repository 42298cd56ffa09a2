"""Statistics of a comparison: every contender's risks, and the difference of every pair on the same flights."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from objectives.risk import RELEVANT, resampled_scenarios, within
from objectives.risk.differences import BETTER, WORSE
from plant.seeds import generator
from tuner.analysis.held_out import TABLE_REPLICATES
from tuner.documents.parts import SampledValue
from tuner.documents.verdicts import verdict_on_difference
from tuner.experiments.compare.flying import Flown
from tuner.study.comparison import Quantity

MIRRORED = {BETTER: WORSE, WORSE: BETTER}
"""Word on the second of a pair -> word on the first."""


@dataclass(frozen=True)
class Difference:
    """One quantity of two contenders, by index.

    Attributes:
        estimate: `second` minus `first`, paired over flights; below 0: second better.
        reference: Value of the first.
        relevant: Share of it from which a difference matters.
    """

    first: int
    second: int
    quantity: int
    estimate: SampledValue
    reference: float
    relevant: float = RELEVANT

    @property
    def word(self) -> str:
        """The word on the second."""
        return verdict_on_difference(self.reference, self.estimate, self.relevant)

    @property
    def winner(self) -> int | None:
        """The better contender, None where the rule calls neither so."""
        return {BETTER: self.second, WORSE: self.first}.get(self.word)


@dataclass(frozen=True)
class Comparison:
    """estimates[contender][quantity]; differences: of every pair in every quantity, first before second."""

    estimates: list[list[SampledValue]]
    differences: list[Difference]

    def difference(self, contender: int, other: int, quantity: int) -> SampledValue:
        """Return contender minus other."""
        estimate = self._pair(contender, other, quantity).estimate
        return estimate if contender > other else SampledValue(-estimate.value, -estimate.high, -estimate.low)

    def word(self, contender: int, other: int, quantity: int) -> str:
        """Return the word on contender beside other."""
        word = self._pair(contender, other, quantity).word
        return word if contender > other else MIRRORED.get(word, word)

    def _pair(self, contender: int, other: int, quantity: int) -> Difference:
        first, second = sorted((contender, other))
        return next(d for d in self.differences if (d.first, d.second, d.quantity) == (first, second, quantity))


def compare_all(flown: Flown, quantities: tuple[Quantity, ...], root: int, relevant: float = RELEVANT) -> Comparison:
    """Estimate every risk and paired difference with its 95 % interval.

    Intervals are over scenarios, as a run's table has them. All contenders and quantities see the same resamples of the
    same flights. relevant: share of the first contender's value from which a difference matters.
    """
    count = len(flown.scores)
    estimates: list[list[SampledValue]] = [[] for _ in range(count)]
    differences = []
    drawn = resampled_scenarios(generator(root, "bootstrap/contest", 0), TABLE_REPLICATES, flown.origin)
    for i, quantity in enumerate(quantities):
        objective, scenario = quantity.objective, quantity.objective.scenario
        samples, part = flown.samples(i, scenario), within(drawn, flown.origin, scenario)
        intervals = zip(objective.risk.apply(samples), *objective.interval(samples, part), strict=True)
        for column, ends in zip(estimates, intervals, strict=True):
            column.append(SampledValue(*map(float, ends)))
        for first, second in combinations(range(count), 2):
            gap = objective.difference(samples[second], samples[first], part)
            # Who flew every flight alike to the bit is the same: nothing is open, not even losses that were not seen.
            same = np.array_equal(flown.scores[first], flown.scores[second])
            value = SampledValue(0.0, 0.0, 0.0) if same else SampledValue(*map(float, gap))
            differences.append(Difference(first, second, i, value, estimates[first][i].value, relevant))
    return Comparison(estimates, differences)
