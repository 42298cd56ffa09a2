"""What a target documents of its parameters, and the numbers of an export held against it."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from math import isfinite

from plant.errors import InputError
from tuner.exchange.autopilot.parameter_text import MOST, single
from tuner.exchange.exporter import Parameter

Rounding = Callable[[float], float]
NOTHING: Mapping[str, float] = {}


@dataclass(frozen=True)
class Entry:
    """One parameter of a target: name, unit, documented range and default, and what of ours it follows from."""

    name: str
    unit: str
    low: float
    high: float
    usual: float
    source: str


def unbounded(name: str, unit: str, low: float, usual: float, source: str) -> Entry:
    """Return an entry without a documented upper limit; that of float32 stands in its place."""
    return Entry(name, unit, low, MOST, usual, source)


def parameters(
    table: Mapping[str, Entry],
    values: Mapping[str, float],
    rounding: Rounding,
    target: str,
    before: Mapping[str, float] = NOTHING,
    kept: Collection[str] = (),
) -> tuple[Parameter, ...]:
    """Return every value with its entry, rounded; target: name and version, for the messages; before: what is on the vehicle;
    kept: names that stay as they are there.

    Raises InputError naming the parameter where a value is not finite or leaves the documented range: nothing on the vehicle
    would say so, for no autopilot checks ranges when a file is loaded. What the vehicle has already is no concern of ours.
    """
    found = [_parameter(table[name], value, rounding, before.get(name), name in kept) for name, value in values.items()]
    outside = [parameter for parameter in found if not fits(parameter)]
    if outside:
        further = [f"{parameter.name} {_outside(table[parameter.name], parameter.asked)}" for parameter in outside[1:]]
        raise InputError(
            f"{_outside(table[outside[0].name], outside[0].asked)}; {target} documents these ranges"
            + "".join(f"; {text}" for text in further),
            key=outside[0].name,
        )
    return tuple(found)


def fits(parameter: Parameter) -> bool:
    """Return whether a value lies in its documented range, or is on the vehicle already."""
    return parameter.low <= parameter.held <= parameter.high or parameter.held == parameter.before


def _parameter(entry: Entry, asked: float, rounding: Rounding, before: float | None, kept: bool) -> Parameter:
    held = rounding(asked) if isfinite(asked) else asked
    low, high = single(entry.low), single(entry.high)
    return Parameter(entry.name, entry.unit, asked, held, low, high, entry.usual, before, kept)


def _outside(entry: Entry, asked: float) -> str:
    unit = "" if entry.unit == "1" else f" {entry.unit}"
    limit = f"at least {entry.low:g}" if entry.high == MOST else f"{entry.low:g} to {entry.high:g}"
    return f"works out at {asked:.6g}{unit}, allowed {limit}{unit}: change {entry.source}"


def misfit(table: Mapping[str, Entry], values: Mapping[str, float]) -> float:
    """Return how far values leave their documented ranges, each in widths of its range, added up; 0 where all fit."""
    return sum(_overshoot(table[name], value) for name, value in values.items())


def _overshoot(entry: Entry, value: float) -> float:
    low, high, given = single(entry.low), single(entry.high), single(value)
    return max(low - given, given - high, 0.0) / (high - low)


def defaults(table: Mapping[str, Entry]) -> dict[str, float]:
    """Return the target's default of every parameter."""
    return {entry.name: entry.usual for entry in table.values()}
