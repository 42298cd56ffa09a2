"""Every metric by name."""

from operator import attrgetter

from objectives.metrics.axis import AXIS_METRICS
from objectives.metrics.flight import FLIGHT_METRICS
from objectives.metrics.metric import Metric
from objectives.metrics.noise import NOISE
from plant.registry import Registry

METRICS: Registry[Metric] = Registry("metric", attrgetter("name"), (*AXIS_METRICS, *FLIGHT_METRICS, NOISE))
