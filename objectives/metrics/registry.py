"""Every metric by name."""

from objectives.metrics.axis import AXIS_METRICS
from objectives.metrics.flight import FLIGHT_METRICS
from objectives.metrics.metric import Metric

METRICS: dict[str, Metric] = {metric.name: metric for metric in (*AXIS_METRICS, *FLIGHT_METRICS)}
