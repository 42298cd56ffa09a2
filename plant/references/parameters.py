"""Parameters of a reference: dataclass fields that carry unit, meaning and range, checked in one place."""

from collections.abc import Mapping
from dataclasses import MISSING, Field, field, fields
from math import isfinite
from typing import Any, NamedTuple

from plant.errors import InputError


class Parameter(NamedTuple):
    """One parameter as a listing shows it; default is None where the user must give it."""

    name: str
    unit: str
    default: float | str | None
    meaning: str


def number(
    unit: str,
    meaning: str,
    *,
    default: float | None = None,
    above: float | None = None,
    low: float | None = None,
    high: float | None = None,
) -> Any:  # noqa: ANN401  (as dataclasses.field: the annotation beside it is what counts)
    """Declare a number of a reference: above is exclusive, low and high inclusive; no default: required."""
    details = {"unit": unit, "meaning": meaning, "above": above, "low": low, "high": high}
    return field(metadata=details) if default is None else field(default=default, metadata=details)


def parameters(kind: type) -> tuple[Parameter, ...]:
    """Return the parameters of a reference class in file order."""
    return tuple(
        Parameter(f.name, f.metadata["unit"], None if f.default is MISSING else f.default, f.metadata["meaning"])
        for f in fields(kind)
        if f.init
    )


def check_numbers(spec: Any) -> None:  # noqa: ANN401  (any dataclass instance)
    """Make the numbers of a frozen dataclass floats; InputError with the field as key if one is not allowed."""
    for f in fields(spec):
        if "above" in f.metadata:
            object.__setattr__(spec, f.name, _checked(getattr(spec, f.name), f))


def _checked(value: object, f: "Field[Any]") -> float:
    unit = f.metadata["unit"]
    # bool is a subclass of int: true would silently become 1 m.
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise InputError(f"is {value!r}; it must be a finite number in {unit}", key=f.name)
    above, low, high = (f.metadata[bound] for bound in ("above", "low", "high"))
    too_low = (above is not None and value <= above) or (low is not None and value < low)
    if too_low or (high is not None and value > high):
        raise InputError(f"is {value:g} {unit}; it must be {_range(f.metadata)} {unit}", key=f.name)
    return float(value)


def _range(bounds: Mapping[str, Any]) -> str:
    words = {"above": "above", "low": "at least", "high": "at most"}
    return " and ".join(f"{word} {bounds[name]:g}" for name, word in words.items() if bounds[name] is not None)
