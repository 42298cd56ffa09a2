"""Accumulators that metrics bring along, next to those of every flight: a record for each axis that a study asks for."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

from objectives.flown_system import FlownSystem, Scenario
from objectives.meters import AxisMeter
from objectives.metrics.address import MetricAddress, check
from objectives.metrics.metric import Accumulator
from objectives.metrics.over_inputs import ROTORS, over_inputs
from plant.errors import InputError
from plant.loop import MeterModel
from plant.model.functions import written
from plant.records import pack, record_type, size
from plant.sample import AxisSample, Target

S = TypeVar("S", bound=FlownSystem)


class Place(NamedTuple):
    """Where an accumulator runs. name: its field of the meters; axis: "" for the whole flight."""

    name: str
    axis: str
    accumulator: Accumulator

    def started(self, number: int) -> str:
        """Return the call that begins it."""
        seen = f"sample.{self.axis}, targets.{self.axis}" if self.axis else "sample, targets"
        return f"start_{number}({seen})"

    def updated(self, number: int) -> str:
        """Return the call that takes it through one more instant."""
        seen = f"sample.{self.axis}, targets.{self.axis}, sample.time, h" if self.axis else "sample, targets, h"
        return f"update_{number}(meters.{self.name}, {seen})"


def metering(system: S, addresses: Iterable[MetricAddress]) -> S:
    """Return a system that meters some metrics; itself if it already does."""
    addresses = list(addresses)
    watching = system.watching(axis for each in addresses for axis in each.axes)
    metered = {each.text: each for each in system.metered}
    needed = {each.text: each for each in addresses if each.metric.accumulator is not None}
    for each in needed.values():
        _check_rate(each, system.timing.control_period)
    return (
        watching if needed.keys() <= metered.keys() else replace(watching, metered=tuple((metered | needed).values()))
    )


def check_on_flights(address: MetricAddress, system: FlownSystem, spec: Scenario) -> None:
    """Raise InputError for a metric without meaning in a scenario."""
    check(address, system.watching(address.axes).targets(spec), spec.duration)


def _check_rate(address: MetricAddress, h: float) -> None:
    slowest = 0.0 if address.metric.accumulator is None else address.metric.accumulator.counts_above
    if 2.0 * h * slowest >= 1.0:
        raise InputError(
            f"given '{address}', which counts above {slowest:g} Hz; a control period of {h:g} s shows less than {0.5 / h:g} Hz: "
            "judge by travel, or take a shorter period",
            key="metric",
        )


def with_accumulators(
    model: MeterModel, metered: Iterable[MetricAddress], scales: Mapping[str, float] = ROTORS
) -> MeterModel:
    """Return a model's meters followed by the accumulators of some metrics.

    scales: what the command of each input of the loop is counted in.
    """
    places = tuple({place.name: place for place in _places(metered, scales)}.values())
    if not places:
        return model
    bundled_fields = model.Meters.__annotations__
    axes = [name for name, kind in bundled_fields.items() if kind is AxisMeter]
    for place in places:
        if not place.axis:
            _check_names(place, axes, scales)
    Meters = record_type("Meters", {**bundled_fields, **{place.name: place.accumulator.Record for place in places}})
    names = {"Meters": Meters, "Bundled": model.Meters, "start_bundled": model.start, "update_bundled": model.update}
    for number, place in enumerate(places):
        names |= {f"start_{number}": place.accumulator.start, f"update_{number}": place.accumulator.update}
    bundled = ", ".join(f"bundled.{name}" for name in bundled_fields)
    start = [
        "def start(sample, targets):",
        "    bundled = start_bundled(sample, targets)",
        f"    return Meters({bundled}, {', '.join(place.started(number) for number, place in enumerate(places))})",
    ]
    update = [
        "def update(meters, sample, targets, h):",
        f"    bundled = update_bundled(Bundled({', '.join(f'meters.{name}' for name in bundled_fields)}), sample, targets, h)",
        f"    return Meters({bundled}, {', '.join(place.updated(number) for number, place in enumerate(places))})",
    ]
    return MeterModel(Meters, written("start", start, names), written("update", update, names))


def _check_names(place: Place, axes: Iterable[str], inputs: Iterable[str]) -> None:
    """Refuse an accumulator of the flight that reads another system's names.

    The compiler of the kernel would end the run with a traceback.
    """
    command = record_type("Command", dict.fromkeys(inputs, float))
    kinds = {
        "time": float,
        **dict.fromkeys(axes, AxisSample),
        "command": command,
        "previous": command,
        "saturated": float,
    }
    sample, targets = (
        pack(kind, [1.0] * size(kind))
        for kind in (record_type("FlightSample", kinds), record_type("Targets", dict.fromkeys(axes, Target)))
    )
    try:
        with suppress(ArithmeticError, ValueError):  # any numbers serve, because only names matter
            place.accumulator.update(place.accumulator.start(sample, targets), sample, targets, 1.0)
    except AttributeError as error:
        seen: Any = error.obj
        if not isinstance(seen, (type(sample), command, type(targets))):
            raise
        raise InputError(
            f"given '{place.name.removeprefix('own_')}', which reads '{error.name}' of a flight; this system has "
            f"{', '.join(seen._fields)}: choose a metric that reads these alone",
            key="metric",
        ) from error


def _places(metered: Iterable[MetricAddress], scales: Mapping[str, float]) -> Iterator[Place]:
    for address in metered:
        if address.metric.accumulator is not None:
            for axis in address.axes or ("",):
                yield Place(address.metric.meter_name(axis), axis, over_inputs(address.metric.accumulator, scales))


def code_of(metered: Iterable[MetricAddress]) -> list[Any]:
    """Return the code of some metrics' accumulators, for a digest."""
    return [(name, axis, adder.Record, adder.start, adder.update) for name, axis, adder in _places(metered, ROTORS)]
