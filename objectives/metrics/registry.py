"""Every metric by name: those of the core, then those of this distribution's extensions."""

import sys
from importlib import import_module
from operator import attrgetter

from objectives.metrics.axis import AXIS_METRICS
from objectives.metrics.flight import FLIGHT_METRICS
from objectives.metrics.metric import Metric
from objectives.metrics.noise import NOISE
from plant.entry_points import DISTRIBUTION, METRIC_GROUP, entry_points
from plant.registry import Registry

OF_EXTENSIONS = [
    import_module(name.partition(":")[0]).METRIC for _, name in entry_points(METRIC_GROUP, sys.path, DISTRIBUTION)
]
METRICS: Registry[Metric] = Registry(
    "metric", attrgetter("name"), (*AXIS_METRICS, *FLIGHT_METRICS, NOISE, *OF_EXTENSIONS)
)
