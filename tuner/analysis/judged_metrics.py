"""Metrics that apply to flights of a system through a scenario."""

from objectives.flown_system import FlownSystem, Scenario
from objectives.metrics import METRICS, MetricAddress, check, parse
from objectives.own_meters import metering
from plant.errors import InputError
from tuner.study.plant_study import check_bounds


def shown_metrics(system: FlownSystem, spec: Scenario) -> list[MetricAddress]:
    """Return the metrics of flights and channels that apply to a scenario."""
    names = [
        [metric.name] if metric.scope == "flight" else [f"{metric.name}.{name}" for name in system.laws]
        for metric in METRICS.values()
    ]
    metrics = [parse(address, system.axes) for group in names for address in group]
    return [metric for metric in metrics if is_judged(system, metric, spec)]


def is_judged(system: FlownSystem, metric: MetricAddress, spec: Scenario) -> bool:
    """Return True if flights have the steps, windows, limits and rate needed."""
    try:
        check(metric, system.targets(spec), spec.duration)
        check_bounds(system, [metric])
        metering(system, [metric])
    except InputError:
        return False
    return True
