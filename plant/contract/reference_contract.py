"""The contract of a reference: numbers with a meaning, and samples that begin at rest, are finite and belong together."""

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from plant.contract.law_description import NAME
from plant.contract.violation import ContractViolation, violations_of
from plant.errors import InputError
from plant.references.parameters import Parameter, parameters
from plant.references.spec import POSITION, VELOCITY, WIDTH, YAW, YAW_RATE, ReferenceSpec, Track
from plant.references.track import AXES

# Control period and length of the flight that is looked at [s].
PERIOD, SECONDS = 0.004, 12.0
# Where a parameter has no default, a number in the middle of what it allows is tried.
USUAL = 1.0


def violations_of_reference(kind: Any, file: str) -> list[ContractViolation]:
    """Return the violations of a reference, up to the first clause that has one."""
    for clause in (is_described, samples_are_right):
        violations = violations_of(lambda clause=clause: clause(kind), kind, file)
        if violations:
            return violations
    return []


def check_reference(kind: Any, file: str) -> Any:
    """Return a reference that a study can describe; raises InputError with the place of the first thing against it."""
    for violation in violations_of(lambda: is_described(kind), kind, file):
        raise violation.error
    return kind


def is_described(kind: Any) -> Iterator[ContractViolation]:
    """A frozen dataclass with a name, a sentence about itself, and parameters with unit and meaning."""
    if not (isinstance(kind, type) and issubclass(kind, ReferenceSpec) and is_dataclass(kind)):
        yield ContractViolation(
            "", f"REFERENCE is {kind!r}; it must be a class of ReferenceSpec with @dataclass(frozen=True, kw_only=True)"
        )
        return
    if not re.fullmatch(NAME, str(getattr(kind, "kind", ""))):
        yield ContractViolation("", 'has no name; write kind: ClassVar[str] = "my_track" in the class')
    if not (kind.__doc__ or "").strip() or (kind.__doc__ or "").startswith(f"{kind.__name__}("):
        yield ContractViolation("", "has no docstring; write one sentence that says what is flown")
    for entry in fields(kind):
        if entry.init and not {"unit", "meaning"} <= set(entry.metadata):
            yield ContractViolation(
                "", f'the parameter \'{entry.name}\' has no unit; write {entry.name}: float = number("m", "meaning")'
            )


def samples_are_right(kind: type[ReferenceSpec]) -> Iterator[ContractViolation]:
    """A track of the right shape, finite, at rest at its start, whose velocity is that of its position."""
    try:
        spec = kind(**{entry.name: _usual(entry, kind) for entry in parameters(kind)})
    except InputError as error:
        yield ContractViolation("", f"is refused with usual parameters: {error}; give defaults that can be flown")
        return
    t = PERIOD * np.arange(round(SECONDS / PERIOD))
    track: Any = spec.track(t)
    if not isinstance(track, Track):
        yield ContractViolation(
            "track", f"gives {type(track).__name__}; it must give Track, as without_step and Track(...) do"
        )
    elif track.samples.shape != (t.size, WIDTH):
        yield ContractViolation(
            "track", f"gives samples of shape {track.samples.shape}; it must be {(t.size, WIDTH)}, as blank(t.size) is"
        )
    else:
        yield from _values(track)
        repeated = spec.track(t)
        if not np.array_equal(track.samples, repeated.samples, equal_nan=True):
            yield ContractViolation(
                "track", "gives other samples when it is asked again: the same parameters must give the same track"
            )


def _values(track: Track) -> Iterator[ContractViolation]:
    samples = track.samples
    if not np.isfinite(samples).all():
        row = int(np.nonzero(~np.isfinite(samples).all(axis=1))[0][0])
        yield ContractViolation("track", f"gives a number that is not finite at t = {row * PERIOD:g} s")
        return
    if np.any(samples[0, VELOCITY] != 0.0):
        yield ContractViolation("track", "moves at t = 0; a flight starts at rest, so blend the motion in")
    levels = np.shape(track.start), np.shape(track.final)
    if levels != ((len(AXES),), (len(AXES),)):
        yield ContractViolation(
            "track", f"gives start and final of shapes {levels[0]} and {levels[1]}; both must be ({len(AXES)},)"
        )
    for what, places, rates in (
        ("velocity", samples[:, POSITION], samples[:, VELOCITY]),
        ("yaw rate", samples[:, [YAW]], samples[:, [YAW_RATE]]),
    ):
        if problem := _rate_problem(places, rates):
            yield ContractViolation("track", f"gives a {what} {problem}")


def _rate_problem(places: np.ndarray, rates: np.ndarray) -> str:
    """Return the first instant whose rate is not that of the position; "" for none, and a step's leap has none."""
    gained, mean = np.diff(places, axis=0) / PERIOD, 0.5 * (rates[1:] + rates[:-1])
    # A leap in one period is faster than any vehicle.
    leaps = np.abs(gained) > 1.0 / PERIOD * 0.05
    # The trapezoid is off by h^2/12 of the third derivative: 1e-3 leaves room for 750 m/s3.
    off = (np.abs(gained - mean) > 1e-3 + 0.02 * np.abs(mean)) & ~leaps
    if not off.any():
        return ""
    row = int(np.nonzero(off.any(axis=1))[0][0])
    return f"that is not the rate of its position from t = {row * PERIOD:g} s on"


def _usual(entry: Parameter, kind: type) -> Any:
    if entry.default is not None:
        return entry.default
    bounds = next(field.metadata for field in fields(kind) if field.name == entry.name)
    low, high = bounds.get("low"), bounds.get("high")
    if low is not None and high is not None:
        return 0.5 * (low + high)
    if low is not None or bounds.get("above") is not None:
        return (low if low is not None else bounds["above"]) + USUAL
    return USUAL if high is None else min(USUAL, high)
