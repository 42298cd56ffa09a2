"""Accumulators that metrics bring along, beside those of every flight: a record for each axis that a study asks for."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from objectives.metrics.address import MetricAddress
from plant.loop import MeterModel
from plant.model.functions import written
from plant.records import record_type

Function = Callable[..., Any]


def metering(system: Any, addresses: Iterable[MetricAddress]) -> Any:
    """Return a system whose flights hold all that some metrics need, the system itself where they do already."""
    known = {each.text: each for each in system.metered}
    asked = {each.text: each for each in addresses if each.metric.accumulator is not None}
    return system if asked.keys() <= known.keys() else replace(system, metered=tuple((known | asked).values()))


def with_accumulators(model: MeterModel, metered: tuple[MetricAddress, ...]) -> MeterModel:
    """Return meters that hold the accumulators of some metrics behind those of a model; the model itself where there are none."""
    asked = {
        address.metric.meter_name(axis): (address.metric, axis) for address in metered for axis in address.axes or ("",)
    }
    if not asked:
        return model
    kept = model.Meters.__annotations__
    records = {name: metric.accumulator.Record for name, (metric, _) in asked.items()}
    Meters = record_type("Meters", {**kept, **records})
    names = {"Meters": Meters, "Bundled": model.Meters, "start_bundled": model.start, "update_bundled": model.update}
    bundled = ", ".join(f"bundled.{name}" for name in kept)
    begun = ", ".join(_started(number, axis) for number, (_, axis) in enumerate(asked.values()))
    moved = ", ".join(_updated(number, name, axis) for number, (name, (_, axis)) in enumerate(asked.items()))
    for number, (metric, _) in enumerate(asked.values()):
        names |= {f"start_{number}": metric.accumulator.start, f"update_{number}": metric.accumulator.update}
    start = [
        "def start(sample, targets):",
        "    bundled = start_bundled(sample, targets)",
        f"    return Meters({bundled}, {begun})",
    ]
    update = [
        "def update(meters, sample, targets, h):",
        f"    bundled = update_bundled(Bundled({', '.join(f'meters.{name}' for name in kept)}), sample, targets, h)",
        f"    return Meters({bundled}, {moved})",
    ]
    return MeterModel(Meters, written("start", start, names), written("update", update, names))


def _started(number: int, axis: str) -> str:
    seen = f"sample.{axis}, targets.{axis}" if axis else "sample, targets"
    return f"start_{number}({seen})"


def _updated(number: int, name: str, axis: str) -> str:
    seen = f"sample.{axis}, targets.{axis}, sample.time, h" if axis else "sample, targets, h"
    return f"update_{number}(meters.{name}, {seen})"


def code_of(metered: tuple[MetricAddress, ...]) -> list[Any]:
    """Return all that the accumulators of some metrics are made of, for a digest."""
    parts = [(each.text, each.metric.accumulator) for each in metered if each.metric.accumulator is not None]
    return [(text, kept.Record, kept.start, kept.update) for text, kept in parts]
