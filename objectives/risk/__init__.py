"""Risk: what is made of one value per scenario (`RISKS`), and how sure it is (`interval_on`)."""

from objectives.risk.bootstrap import (
    PairedDifference,
    interval_on,
    paired_difference_on,
    replicates_on,
)
from objectives.risk.differences import RELEVANT, classify_difference, join_words
from objectives.risk.joint import resampled_scenarios, within
from objectives.risk.measures import PROBABILITY, RISKS, Interval, Risk, RiskMeasure, minimum_samples
from objectives.risk.shares import (
    binary_difference,
    binary_interval,
    clopper_pearson,
    flights_to_show,
    share_difference,
    upper_bound,
)
from objectives.risk.wilks import bound_rank, flights_to_bound

__all__ = [
    "PROBABILITY", "RELEVANT", "RISKS", "Interval", "PairedDifference", "Risk", "RiskMeasure", "binary_difference",
    "binary_interval", "bound_rank", "classify_difference", "clopper_pearson", "flights_to_bound", "flights_to_show",
    "interval_on", "join_words", "minimum_samples", "paired_difference_on", "replicates_on", "resampled_scenarios",
    "share_difference", "upper_bound", "within",
]  # fmt: skip
