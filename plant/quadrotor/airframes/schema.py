"""Schema of an airframe file: one unit per number, and the range outside which a number is meaningless.

Every number is an inline table, so that none stands without its unit and where it comes from:

    mass = { value = 0.698, unit = "kg", source = "weighed, with battery" }
"""

from collections.abc import Callable, Mapping
from math import isfinite
from pathlib import Path
from typing import NamedTuple

from plant.errors import InputError, UnknownNameError, check_name
from plant.quadrotor.thrust_curve import MAX_LINEAR, MIN_LINEAR


class Sourced(NamedTuple):
    """One number of an airframe file as written: value in SI, its unit, and where it comes from."""

    value: float
    unit: str
    source: str


class NumberField(NamedTuple):
    """The one unit a number is given in, and its range: a key of `_SIGN_TESTS`."""

    unit: str
    sign: str


GROUPS: dict[str, NumberField] = {
    "inertia": NumberField("kg m2", "positive"),
    "drag_linear": NumberField("N s/m", "not negative"),
    "drag_quadratic": NumberField("N s2/m2", "not negative"),
    "rate_damping": NumberField("N m s", "not negative"),
}
SCALARS: dict[str, NumberField] = {
    "mass": NumberField("kg", "positive"),
    "thrust_coefficient": NumberField("N s2", "positive"),
    "torque_ratio": NumberField("m", "positive"),
    "rotor_inertia": NumberField("kg m2", "not negative"),
    "lag_up": NumberField("s", "positive"),
    "lag_down": NumberField("s", "positive"),
    "speed_min": NumberField("rad/s", "not negative"),
    "speed_max": NumberField("rad/s", "positive"),
    "drag_height": NumberField("m", "any"),
    "gravity": NumberField("m/s2", "positive"),
}
OPTIONAL: dict[str, NumberField] = {
    "dead_time": NumberField("s", "not negative"),
    "thrust_linear": NumberField("1", "above -1 and at most 1"),
    "vibration_1": NumberField("rad/s", "not negative"),
    "vibration_2": NumberField("rad/s", "not negative"),
    "vibration_3": NumberField("rad/s", "not negative"),
    "gyro_cutoff": NumberField("Hz", "not negative"),
    "mode_frequency": NumberField("Hz", "positive"),
    "mode_damping": NumberField("1", "positive"),
    "mode_gain": NumberField("1", "any"),
    "battery_full": NumberField("V", "positive"),
    "battery_empty": NumberField("V", "positive"),
    "battery_resistance": NumberField("Ohm", "not negative"),
    "battery_capacity": NumberField("A s", "positive"),
    "battery_used": NumberField("A s", "not negative"),
    "hover_power": NumberField("W", "positive"),
}
"""Numbers that a file may leave out: 0."""
SENSORS: dict[str, NumberField] = {"gyro_noise": NumberField("rad/s/sqrt(Hz)", "not negative")}
"""Default sensors of studies without any; a file may leave them out."""
TOGETHER = {
    "a mode of the frame": ("mode_frequency", "mode_damping", "mode_gain"),
    "a battery": ("battery_full", "battery_empty", "battery_resistance", "battery_capacity", "hover_power"),
}
"""Numbers of which a file gives all or none, by what they are of."""
LENGTH = NumberField("m", "positive")
HEADER = ("title", "frame", "spin", "allow_unphysical", "uncertainty")

_SIGN_TESTS: dict[str, Callable[[float], bool]] = {
    "positive": lambda v: v > 0.0,
    "not negative": lambda v: v >= 0.0,
    "any": lambda v: True,
    "above -1 and at most 1": lambda v: MIN_LINEAR < v <= MAX_LINEAR,
}


def number_fields(lengths: tuple[str, ...]) -> dict[str, NumberField]:
    """Return dotted key -> NumberField of a file's required numbers, for a frame with these lengths."""
    grouped = {f"{group}.{axis}": field for group, field in GROUPS.items() for axis in "xyz"}
    return {**SCALARS, **grouped, **dict.fromkeys(lengths, LENGTH)}


def read_numbers(table: Mapping[str, object], lengths: tuple[str, ...], file: Path) -> dict[str, Sourced]:
    """Return dotted key -> Sourced for exactly the numbers of `number_fields` and those optional ones that are given.

    Raises InputError on anything else.
    """
    leaves = _flattened(table, file)
    fields = number_fields(lengths) | {key: field for key, field in (OPTIONAL | SENSORS).items() if key in leaves}
    for key in leaves:
        if key not in fields:
            raise UnknownNameError("key", key, [*fields, *OPTIONAL, *SENSORS, *HEADER], file=file, key=key)
    return {key: _read_number(leaves, key, field, file) for key, field in fields.items()}


def check_together(sources: Mapping[str, Sourced], file: Path) -> None:
    """Raise InputError for an incomplete mode or battery, or an impossible charge."""
    for component, keys in TOGETHER.items():
        missing = [key for key in keys if key not in sources]
        if 0 < len(missing) < len(keys):
            raise InputError(
                f"is missing; {component} needs {', '.join(keys)}: give all of them or none", file=file, key=missing[0]
            )
    for key, most in (("battery_empty", "battery_full"), ("battery_used", "battery_capacity")):
        if key in sources and (most not in sources or sources[key].value > sources[most].value):
            raise InputError(f"is {sources[key].value:g}; it needs {most}, and must not exceed it", file=file, key=key)


def read_text(table: Mapping[str, object], key: str, file: Path, allowed: tuple[str, ...] = ()) -> str:
    """Return a non-empty string of the file's header, one of `allowed` if any are given."""
    text = table.get(key)
    choice = f"one of {', '.join(repr(name) for name in allowed)}" if allowed else "a text"
    if not isinstance(text, str) or not text.strip():
        raise InputError(f"{_given(table, key)}; it must be {choice}", file=file, key=key)
    if allowed and text not in allowed:
        raise UnknownNameError(key, text, allowed, file=file, key=key)
    return text


def read_flag(table: Mapping[str, object], key: str, file: Path) -> bool:
    """Return a true or false of the file's header; false where it is not given."""
    flag = table.get(key, False)
    if not isinstance(flag, bool):
        raise InputError(f"{_given(table, key)}; it must be true or false (or be left out: false)", file=file, key=key)
    return flag


def _flattened(table: Mapping[str, object], file: Path) -> dict[str, object]:
    leaves: dict[str, object] = {}
    for key, entry in table.items():
        if key in GROUPS:
            if not isinstance(entry, dict):
                message = f"is {entry!r}; it must give x, y and z: {key}.x = {_example(GROUPS[key])}"
                raise InputError(message, file=file, key=key)
            leaves.update({f"{key}.{axis}": leaf for axis, leaf in entry.items()})
        elif key not in HEADER:
            leaves[key] = entry
    return leaves


def _read_number(leaves: Mapping[str, object], key: str, field: NumberField, file: Path) -> Sourced:
    leaf = leaves.get(key)
    if not isinstance(leaf, dict):
        raise InputError(f"{_given(leaves, key)}; write {key} = {_example(field)}", file=file, key=key)
    for part in leaf:
        check_name("key", part, Sourced._fields, file=file, key=f"{key}.{part}")
    value = _checked_value(leaf, key, field, file)
    if leaf.get("unit") != field.unit:
        message = f'{_given(leaf, "unit")}; only unit = "{field.unit}" is allowed: convert the value'
        raise InputError(message, file=file, key=f"{key}.unit")
    source = leaf.get("source")
    if not isinstance(source, str) or not source.strip():
        message = f'{_given(leaf, "source")}; say where the value comes from, or source = "assumed: <why this size>"'
        raise InputError(message, file=file, key=f"{key}.source")
    return Sourced(value, field.unit, source)


def _checked_value(leaf: Mapping[str, object], key: str, field: NumberField, file: Path) -> float:
    value = leaf.get("value")
    # bool is a subclass of int: true would silently become 1 kg.
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        message = f"{_given(leaf, 'value')}; it must be a finite number in {field.unit}"
        raise InputError(message, file=file, key=f"{key}.value")
    if not _SIGN_TESTS[field.sign](value):
        raise InputError(f"is {value:g} {field.unit}; it must be {field.sign}", file=file, key=f"{key}.value")
    return float(value)


def _given(table: Mapping[str, object], key: str) -> str:
    return f"is {table[key]!r}" if key in table else "is missing"


def _example(field: NumberField) -> str:
    return f'{{ value = <number>, unit = "{field.unit}", source = "<where it comes from>" }}'
