"""What the flights of a comparison say: every contender's risks, and the difference of every pair on the same flights."""

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from objectives.risk import bootstrap_replicates, percentile_interval
from plant.seeds import generator
from tuner.contest.contest import Quantity
from tuner.contest.flying import Flown
from tuner.held_out import TABLE_REPLICATES, Estimate


@dataclass(frozen=True)
class Difference:
    """One quantity of two contenders, by index: `second` minus `first`, paired over flights; below 0: second better."""

    first: int
    second: int
    quantity: int
    estimate: Estimate

    @property
    def winner(self) -> int | None:
        """The contender that the interval says is lower, or None where it holds 0."""
        if self.estimate.high < 0.0:
            return self.second
        return self.first if self.estimate.low > 0.0 else None


@dataclass(frozen=True)
class Comparison:
    """estimates[contender][quantity]; differences: of every pair in every quantity, first before second."""

    estimates: list[list[Estimate]]
    differences: list[Difference]

    def difference(self, contender: int, other: int, quantity: int) -> Estimate:
        """Return contender minus other."""
        first, second = sorted((contender, other))
        found = next(
            d.estimate for d in self.differences if (d.first, d.second, d.quantity) == (first, second, quantity)
        )
        return found if contender == second else Estimate(-found.value, -found.high, -found.low)


def compare_all(flown: Flown, quantities: tuple[Quantity, ...], root: int) -> Comparison:
    """Put 95 % bootstrap intervals over scenarios on every risk and on every paired difference.

    All contenders see the same resamples of the same flights, so a difference of replicates is a replicate of the paired
    difference.
    """
    count = len(flown.scores)
    estimates: list[list[Estimate]] = [[] for _ in range(count)]
    differences = []
    for i, quantity in enumerate(quantities):
        risk = quantity.objective.risk
        samples = flown.samples(i, quantity.objective.scenario)
        values = risk.apply(samples)
        draw = generator(root, "bootstrap/contest", i)
        replicates = bootstrap_replicates(samples, risk, draw, TABLE_REPLICATES)
        for k in range(count):
            estimates[k].append(estimate_of(values[k], replicates[k]))
        for first, second in combinations(range(count), 2):
            apart = estimate_of(values[second] - values[first], replicates[second] - replicates[first])
            differences.append(Difference(first, second, i, apart))
    return Comparison(estimates, differences)


def estimate_of(value: Any, replicates: np.ndarray) -> Estimate:
    """Return a value with the 95 % percentile interval of its replicates (replicates,)."""
    low, high = percentile_interval(replicates)
    return Estimate(float(value), float(low), float(high))
