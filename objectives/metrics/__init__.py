"""Metrics, by which flights are judged. Names and definitions: `METRICS`; values: `evaluate`."""

from objectives.metrics.address import MetricAddress, all_addresses, check, parse
from objectives.metrics.columns import COLUMNS, unpack
from objectives.metrics.context import COMPLETED, FlightContext, MetricLimits
from objectives.metrics.evaluate import Scores, evaluate
from objectives.metrics.metric import Accumulator, Metric
from objectives.metrics.registry import METRICS

__all__ = [
    "COLUMNS",
    "COMPLETED",
    "METRICS",
    "Accumulator",
    "FlightContext",
    "MetricLimits",
    "Metric",
    "MetricAddress",
    "Scores",
    "all_addresses",
    "check",
    "evaluate",
    "parse",
    "unpack",
]
