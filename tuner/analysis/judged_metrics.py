"""Metrics that apply to flights of a system through a scenario."""

from collections.abc import Iterable

from objectives.flown_system import FlownSystem, Scenario
from objectives.metrics import METRICS, MetricAddress, parse
from objectives.own_meters import check_on_flights, metering
from plant.errors import InputError
from tuner.study.metric_bounds import check_bounds


def shown_metrics(system: FlownSystem, spec: Scenario, named: Iterable[MetricAddress] = ()) -> list[MetricAddress]:
    """Return the metrics that apply to a scenario.

    They are those of the flight and of channels, RMS and peak of watched signals. Bundled metrics of an axis that add up
    something of their own are taken where they are named, since each makes kernels larger.
    """
    names = [
        [metric.name] if metric.scope == "flight" else [f"{metric.name}.{name}" for name in system.laws]
        for metric in METRICS.values()
        if metric.scope == "flight" or metric.accumulator is None or metric.origin is not None
    ]
    names.append([each.text for each in named if each.metric.accumulator is not None])
    names.append([f"{metric}.{name}" for name in system.watched for metric in ("rms", "peak")])
    metrics = [parse(address, system.axes) for address in dict.fromkeys(name for group in names for name in group)]
    return [metric for metric in metrics if is_judged(system, metric, spec)]


def is_judged(system: FlownSystem, metric: MetricAddress, spec: Scenario) -> bool:
    """Return True if flights have the steps, windows, limits and rate needed."""
    try:
        check_on_flights(metric, system, spec)
        check_bounds(system, [metric])
        metering(system, [metric])
    except InputError:
        return False
    return True
