"""Risk: what is made of one value per scenario (`RISKS`), and how sure it is (`bootstrap_interval`)."""

from objectives.risk.bootstrap import (
    Interval,
    PairedDifference,
    bootstrap_interval,
    bootstrap_replicates,
    paired_difference,
    percentile_interval,
)
from objectives.risk.measures import RISKS, Risk, RiskMeasure, minimum_samples

__all__ = [
    "RISKS", "Interval", "PairedDifference", "Risk", "RiskMeasure", "bootstrap_interval", "bootstrap_replicates",
    "minimum_samples", "paired_difference", "percentile_interval",
]  # fmt: skip
