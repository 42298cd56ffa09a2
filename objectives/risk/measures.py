"""Risk measures: from one value per scenario to one number per candidate.

Losses x_(1) <= ... <= x_(n) over n scenarios; every measure is exact for the sample, nothing is interpolated. Sources:

- CVaR: R. T. Rockafellar, S. Uryasev, "Optimization of conditional value-at-risk", Journal of Risk 2(3):21-41, 2000;
  the form for samples from the same authors' "Conditional value-at-risk for general loss distributions", Journal of
  Banking & Finance 26(7):1443-1471, 2002. A small sample puts it too low.
- Coherence (monotone, translation, homogeneous, subadditive): P. Artzner et al., "Coherent measures of risk",
  Mathematical Finance 9(3):203-228, 1999. The quantile is not subadditive, and may even lie below the mean.
- Scenarios for the worst case: S. S. Wilks, "Determination of sample sizes for setting tolerance limits", Annals of
  Mathematical Statistics 12(1):91-96, 1941.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.errors import InputError, check_name

Values = NDArray[np.float64]

# a n is an integer up to rounding (0.55 * 100 > 55), and the next order statistic must not be taken for that.
ROUNDING = 1e-9

TAIL_SCENARIOS = 8
"""Scenarios in the tail of a measure below which its interval covers too little: with 5, 91 to 93 % instead of 95 %."""


class Interval(NamedTuple):
    """Lower and upper end (...) of a confidence interval."""

    low: Values
    high: Values


@dataclass(frozen=True)
class RiskMeasure:
    """One entry of `RISKS`.

    Attributes:
        definition: one sentence for reports.
        of_sorted(values, level): the measure of values (..., n) in increasing order.
        tail(level): share of the scenarios that decide the value.
        has_level: whether a level between 0 and 1 must be given.
        title: plain words for tables, with {level} and {beyond}, 100 less it, in per cent; "" for the mean, which goes unnamed.
    """

    definition: str
    of_sorted: Callable[[Values, float], Values]
    tail: Callable[[float], float]
    has_level: bool
    title: str = ""


def quantile_rank(level: float, n: int) -> int:
    """Return j = ceil(a n), between 1 and n: x_(j) is the quantile at level a."""
    return min(max(ceil(level * n - ROUNDING), 1), n)


def _mean(values: Values, level: float) -> Values:
    del level
    return np.mean(values, axis=-1)


def _quantile(values: Values, level: float) -> Values:
    return values[..., quantile_rank(level, values.shape[-1]) - 1]


def _cvar(values: Values, level: float) -> Values:
    n = values.shape[-1]
    rank = quantile_rank(level, n)
    tail = np.sum(values[..., rank:], axis=-1)
    return ((rank - level * n) * values[..., rank - 1] + tail) / ((1.0 - level) * n)


def _worst(values: Values, level: float) -> Values:
    del level
    return values[..., -1]


PROBABILITY = "probability"
"""Risk of a rare event, which flights of its own decide."""
RISKS: dict[str, RiskMeasure] = {
    "mean": RiskMeasure("mean over scenarios", _mean, lambda level: 1.0, has_level=False),
    "quantile": RiskMeasure(
        "smallest value that the share `level` of the scenarios does not exceed",
        _quantile,
        lambda level: min(level, 1.0 - level),
        has_level=True,
        title="{level} % quantile",
    ),
    "cvar": RiskMeasure(
        "mean of the worst share 1 - `level` of the scenarios (conditional value-at-risk)",
        _cvar,
        lambda level: 1.0 - level,
        has_level=True,
        title="mean of the worst {beyond} %",
    ),
    # 59 scenarios exceed the 95 % quantile at least once with 95 % confidence (Wilks); as a tail that is TAIL_SCENARIOS/59.
    "worst": RiskMeasure(
        "worst scenario",
        _worst,
        lambda level: TAIL_SCENARIOS / 59,
        has_level=False,
        title="worst scenario",
    ),
    PROBABILITY: RiskMeasure(
        "probability over all flights that could be drawn; on the flights of a study their share",
        _mean,
        lambda level: 1.0,
        has_level=False,
        title="probability",
    ),
}


@dataclass(frozen=True)
class Risk:
    """A risk measure of a study; raises UnknownNameError or InputError where it is none.

    name: key of `RISKS`. level: share of scenarios in (0, 1), for the measures that have one, else None.
    """

    name: str
    level: float | None = None

    def __post_init__(self) -> None:
        check_name("risk", self.name, RISKS)
        if not RISKS[self.name].has_level:
            if self.level is not None:
                raise InputError(f"risk '{self.name}' has no level, but level = {self.level} was given; leave it out")
        elif self.level is None:
            raise InputError(f"risk '{self.name}' needs a level between 0 and 1, for instance level = 0.9")
        elif not 0.0 < self.level < 1.0:
            raise InputError(f"level = {self.level} of risk '{self.name}' must lie between 0 and 1, for instance 0.9")

    @property
    def is_mean(self) -> bool:
        """Whether it is the mean over flights."""
        return self.name in ("mean", PROBABILITY)

    def __str__(self) -> str:
        return self.name if self.level is None else f"{self.name} {self.level:g}"

    def apply(self, values: NDArray[Any], axis: int = -1) -> Values:
        """Return the risk over the scenarios, which lie along axis; the other axes stay."""
        ordered = np.sort(np.moveaxis(np.asarray(values, dtype=np.float64), axis, -1), axis=-1)
        return RISKS[self.name].of_sorted(ordered, self.level or 0.0)


def minimum_samples(risk: Risk) -> int:
    """Return the number of scenarios at which the risk's tail holds `TAIL_SCENARIOS`; below that, warn.

    For the worst case: 59, which with 95 % confidence hold one at or beyond the 95 % quantile.
    """
    return ceil(TAIL_SCENARIOS / RISKS[risk.name].tail(risk.level or 0.0) - ROUNDING)
