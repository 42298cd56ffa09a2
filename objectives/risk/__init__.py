"""Risk: what is made of one value per scenario (`RISKS`), and how sure it is (`bootstrap_interval`)."""

from objectives.risk.bootstrap import (
    Interval,
    PairedDifference,
    bootstrap_interval,
    interval_on,
    paired_difference,
    paired_difference_on,
    replicates_on,
)
from objectives.risk.joint import resampled_scenarios, within
from objectives.risk.measures import RISKS, Risk, RiskMeasure, minimum_samples

__all__ = [
    "RISKS", "Interval", "PairedDifference", "Risk", "RiskMeasure", "bootstrap_interval", "interval_on", "minimum_samples",
    "paired_difference", "paired_difference_on", "replicates_on", "resampled_scenarios", "within",
]  # fmt: skip
