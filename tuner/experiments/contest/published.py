"""Printed numbers against the distribution over seeds that the same experiment has here."""

from dataclasses import dataclass

import numpy as np

from tuner.documents.parts import SampledValue
from tuner.experiments.contest.comparison import Comparison
from tuner.experiments.contest.flying import Flown
from tuner.study.contest import Contest, Published

# A printed number is "inside" where it lies between these percentiles of the flights.
INSIDE = (2.5, 97.5)


@dataclass(frozen=True)
class Cell:
    """A printed number and one contender: mean over flights, 2.5, 50 and 97.5 % points (3,), where the number lies.

    percentile: share of the flights below the printed number in per cent, those equal to it counted half.
    """

    published: Published
    contender: int
    mean: SampledValue
    points: np.ndarray
    percentile: float

    @property
    def inside(self) -> bool:
        """Whether one flight of ours could well have given the printed number."""
        return INSIDE[0] <= self.percentile <= INSIDE[1]


def judge_cells(contest: Contest, flown: Flown, comparison: Comparison) -> list[Cell]:
    """Judge every printed number for each of its contenders."""
    labels = [quantity.label for quantity in contest.quantities]
    names = [contender.name for contender in contest.contenders]
    cells = []
    for entry in contest.published:
        i = labels.index(entry.objective.label)
        for name in entry.contenders:
            k = names.index(name)
            values = flown.samples(i, entry.scenario)[k]
            points = np.quantile(values, [INSIDE[0] / 100.0, 0.5, INSIDE[1] / 100.0], axis=-1)
            cells.append(Cell(entry, k, comparison.estimates[k][i], points, percentile_of(entry.value, values)))
    return cells


def percentile_of(value: float, values: np.ndarray) -> float:
    """Return the percentile of a value among values (n,): 100 times the share below, ties counted half."""
    below, equal = np.mean(values < value, axis=-1), np.mean(values == value, axis=-1)
    return float(100.0 * (below + 0.5 * equal))
