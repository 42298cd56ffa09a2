"""Numbers and files as parameter files have them: float32, positional, never an exponent, always a dot.

Autopilots hold parameters as IEEE 754 binary32, so what is written is the shortest text that reads back as the same float32.
Some ground stations tell integers from reals by the dot and do not know exponents at all (mavros: `float(x) if "." in x else
int(x)`), so 5e-05 is written 0.00005 and 1 is written 1.0.
"""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from plant.errors import InputError, one_line, shortened
from plant.input_files import ReadableFile, given_text
from tuner.exchange.target import HeldParameter
from tuner.text.units import after_number

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
# Comments that tell where a file is from: "# Version: 1.16.0" and "# ArduCopter V3.4.6 (e707341b)".
STATED = re.compile(r"#\s*(Stack|Version):\s*(\S.*?)\s*$")
BANNER = re.compile(r"#.*\b(?:ArduCopter|APM:Copter|Copter)[ -]V?(\d+\.\d+[\w.-]*)")
# Vehicles of ArduPilot that are no Copter, as a banner or QGroundControl names them.
OTHER_BANNER = re.compile(
    r"#.*\b((?:ArduPlane|ArduRover|APMrover2|ArduSub|Blimp|AntennaTracker)(?:[ -]V?\d+\.\d+)?)"
    r"|#\s*Vehicle:\s*(?=Fixed|Rover|Sub|VTOL|Heli)(\S.*?)\s*$"
)
# Largest finite float32: where a target documents no upper limit, this is its limit.
MAX_VALUE = float(np.finfo(np.float32).max)


def single(value: float) -> float:
    """Return a number rounded to float32."""
    return float(np.float32(value))


def positional(value: float) -> str:
    """Return the shortest decimal text of a finite float32: with a dot, without exponent."""
    assert isfinite(value), value
    return np.format_float_positional(np.float32(value + 0.0), unique=True, trim="0")


def read_number(text: str, name: str, file: ReadableFile) -> float:
    """Return a number of a parameter file, exponents allowed; raises InputError naming the parameter."""
    value = float(text) if NUMBER.fullmatch(text) else float("nan")
    if not isfinite(value) or abs(value) > MAX_VALUE:
        raise InputError(f"given '{shortened(text)}'; this must be a finite number", file=file, key=name)
    return value


def read_lines(file: ReadableFile, what: str) -> list[str]:
    """Return the lines of a text file without their ends; what: which file to give, for the message of an InputError."""
    return given_text(file, f"give {what}").splitlines()


@dataclass(frozen=True)
class Stated:
    """Stack and version of the autopilot in a file's comments, or None."""

    stack: str | None = None
    version: str | None = None


def stated(file: ReadableFile, what: str) -> Stated:
    """Return stack and version from a file's comments: of QGroundControl, or a firmware banner."""
    source = Stated()
    for line in read_lines(file, what):
        if match := STATED.match(line):
            source = replace(source, **{match[1].lower(): match[2]})
        elif (match := BANNER.match(line)) and source.version is None:
            source = Stated("ArduPilot", match[1])
    return source


def check_stack(file: ReadableFile, what: str, stack: str) -> None:
    """Refuse a file that says to be of another autopilot; raises InputError naming it."""
    if match := next(filter(None, map(OTHER_BANNER.match, read_lines(file, what))), None):
        raise InputError(
            f"{shortened(match[1] or match[2])} is not supported: its gains mean other torques; give {what}", file=file
        )
    source = stated(file, what).stack
    if source is not None and not source.lower().startswith(stack.lower()):
        message = f"is a file of {shortened(source)}, not of {stack}; give {what}"
        raise InputError(message, file=file, key="# Stack")


def enter(values: dict[str, float], name: str, value: float, file: ReadableFile) -> None:
    """Put a parameter among those read; raises InputError where it stood there with another value."""
    if values.setdefault(name, value) != value:
        message = f"given twice, as {values[name]:.9g} and as {value:.9g}; leave one out"
        raise InputError(message, file=file, key=name)


def as_bytes(lines: list[str]) -> bytes:
    """Return lines as the content of a text file; but for tabs, what does not print comes out as its escape."""
    printing = ["\t".join(map(one_line, line.split("\t"))) for line in lines]
    return ("\n".join(printing) + "\n").encode("ascii", "backslashreplace")


Rounding = Callable[[float], float]
Values = Mapping[str, float]
# Name of a parameter -> value in the target's unit.
NOTHING: Values = {}
# Begin of a source that is an option of the controller, no gain.
OPTIONS = "controller."


@dataclass(frozen=True)
class ParameterInfo:
    """One parameter of a target: name, unit, documented range and default, and what of ours it follows from."""

    name: str
    unit: str
    low: float
    high: float
    usual: float
    source: str


def parameter_table(*entries: ParameterInfo) -> dict[str, ParameterInfo]:
    """Return entries by name, in their order."""
    return {entry.name: entry for entry in entries}


def unbounded(name: str, unit: str, low: float, usual: float, source: str) -> ParameterInfo:
    """Return an entry without a documented upper limit; that of float32 stands in its place."""
    return ParameterInfo(name, unit, low, MAX_VALUE, usual, source)


def parameters(
    table: Mapping[str, ParameterInfo],
    values: Values,
    rounding: Rounding,
    target: str,
    before: Values = NOTHING,
    unchanged: Collection[str] = (),
) -> tuple[HeldParameter, ...]:
    """Return every value with its entry, rounded.

    Raises InputError naming the parameter where a value is not finite or leaves the documented range: no autopilot checks ranges
    when a file is loaded. Values that are on the vehicle already are not checked.

    Args:
        table: entries of the parameters.
        values: to be written, unrounded.
        rounding: rounding of the vehicle.
        target: name and version, for the messages.
        before: values on the vehicle.
        unchanged: names that stay as they are there.
    """
    rounded = [
        _parameter(table[name], value, rounding, before.get(name), name in unchanged) for name, value in values.items()
    ]
    outside = [parameter for parameter in rounded if not parameter.fits]
    if outside:
        further = [
            f"{parameter.name} {_outside(table[parameter.name], parameter.unrounded)}" for parameter in outside[1:]
        ]
        raise InputError(
            f"{_outside(table[outside[0].name], outside[0].unrounded)}; {target} documents these ranges"
            + "".join(f"; {text}" for text in further),
            key=outside[0].name,
        )
    return tuple(rounded)


def _parameter(
    entry: ParameterInfo, unrounded: float, rounding: Rounding, before: float | None, unchanged: bool
) -> HeldParameter:
    held = rounding(unrounded) if isfinite(unrounded) else unrounded
    low, high = single(entry.low), single(entry.high)
    return HeldParameter(entry.name, entry.unit, unrounded, held, low, high, entry.usual, before, unchanged)


def _outside(entry: ParameterInfo, unrounded: float) -> str:
    unit = after_number(entry.unit)
    limit = f"at least {entry.low:g}" if entry.high == MAX_VALUE else f"{entry.low:g} to {entry.high:g}"
    return f"works out at {unrounded:.6g}{unit}, allowed {limit}{unit}: change {entry.source}"


def option_changes(table: Mapping[str, ParameterInfo], written: Collection[HeldParameter]) -> tuple[str, ...]:
    """Return the sentence on written parameters that options change."""
    entries = [
        f"{one.name} {_number(old)}{' (default)' if one.before is None else ''} to {_number(one.held)}"
        f"{after_number(one.unit)}"
        for one in written
        if table[one.name].source.startswith(OPTIONS)
        and (old := one.usual if one.before is None else one.before) is not None
        and _number(old) != _number(one.held)
    ]
    return (
        (f"Besides the gains, the controller's options ([controller] of a study) change {', '.join(entries)}.",)
        if entries
        else ()
    )


def _number(value: float) -> str:
    return f"{value:.6g}"


def range_violation(table: Mapping[str, ParameterInfo], values: Values) -> float:
    """Return the total violation of documented ranges, in widths of the ranges; 0 where all fit."""
    return sum(_overshoot(table[name], value) for name, value in values.items())


def _overshoot(entry: ParameterInfo, value: float) -> float:
    low, high, given = single(entry.low), single(entry.high), single(value)
    return max(low - given, given - high, 0.0) / (high - low)


def defaults(table: Mapping[str, ParameterInfo]) -> dict[str, float]:
    """Return the target's default of every parameter."""
    return {entry.name: entry.usual for entry in table.values()}
