"""Statistics of a comparison: every contender's risks, and the difference of every pair on the same flights."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from objectives.risk import resampled_scenarios, within
from plant.seeds import generator
from tuner.analysis.held_out import TABLE_REPLICATES
from tuner.documents.parts import SampledValue
from tuner.experiments.contest.flying import Flown
from tuner.study.contest import Quantity


@dataclass(frozen=True)
class Difference:
    """One quantity of two contenders, by index: `second` minus `first`, paired over flights; below 0: second better."""

    first: int
    second: int
    quantity: int
    estimate: SampledValue

    @property
    def winner(self) -> int | None:
        """The contender of the lower value, None where the interval holds 0."""
        if self.estimate.high < 0.0:
            return self.second
        return self.first if self.estimate.low > 0.0 else None


@dataclass(frozen=True)
class Comparison:
    """estimates[contender][quantity]; differences: of every pair in every quantity, first before second."""

    estimates: list[list[SampledValue]]
    differences: list[Difference]

    def difference(self, contender: int, other: int, quantity: int) -> SampledValue:
        """Return contender minus other."""
        first, second = sorted((contender, other))
        estimate = next(
            d.estimate for d in self.differences if (d.first, d.second, d.quantity) == (first, second, quantity)
        )
        return estimate if contender == second else SampledValue(-estimate.value, -estimate.high, -estimate.low)


def compare_all(flown: Flown, quantities: tuple[Quantity, ...], root: int) -> Comparison:
    """Estimate every risk and paired difference with its 95 % interval.

    Intervals are over scenarios, as a run's table has them. All contenders and quantities see the same resamples of the
    same flights.
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
            differences.append(Difference(first, second, i, value))
    return Comparison(estimates, differences)
