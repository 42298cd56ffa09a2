"""The contract of a metric: documented, finite for flights inside the limits, within its bound, the same when asked twice."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.meters import AxisMeter, Meters
from objectives.metrics.address import UNITS
from objectives.metrics.columns import COLUMNS, unpack
from objectives.metrics.context import COMPLETED, FlightContext, MetricLimits
from objectives.metrics.metric import COMBINE, Accumulator, AxisView, FlightView, Metric
from objectives.metrics.sampled_flights import Plan, sampled_views
from plant.contract.law_description import NAME
from plant.contract.violation import ContractViolation, violations_of
from plant.errors import InputError
from plant.model.functions import check_model_function
from plant.quadrotor.cascade import AXES
from plant.quadrotor.sample import Targets
from plant.records import is_leaf, is_record
from plant.sample import Target
from plant.texts import check_title

# Flights that are looked at: how many, their control period and length [s].
FLIGHTS, PERIOD, DURATION = 64, 0.004, 2.0
LIMITS = MetricLimits(position_error=5.0, command_peak=3.0)
CHOICES = {
    "scope": ("axis", "flight"),
    "combine": tuple(COMBINE),
    "window": (None, "time", "recovery_from", "steady_from"),
}


def violations_of_metric(metric: Any, file: str) -> list[ContractViolation]:
    """Return the violations of the first clause that a metric violates."""
    for clause in (is_described, accumulator_can_fly, values_are_right):
        owner = getattr(metric, "accumulator", None) or metric
        violations = violations_of(
            lambda clause=clause: clause(metric), owner if clause is accumulator_can_fly else metric, file
        )
        if violations:
            return violations
    return []


def check_metric(metric: Any, file: str) -> Metric:
    """Return a metric by which a study can judge; raises InputError with the place of the first thing against it."""
    for violation in violations_of_metric(metric, file):
        raise violation.error
    return metric


def is_described(metric: Any) -> Iterator[ContractViolation]:
    """Yield the violations of a metric's description.

    It is a `Metric` with a name, a symbol, a definition, and choices that there are.
    """
    if not isinstance(metric, Metric):
        yield ContractViolation("", f"METRIC is {metric!r}; it must be Metric(name=..., value=..., bound=...)")
        return
    if not re.fullmatch(NAME, metric.name):
        yield ContractViolation(
            "",
            f"given the name '{metric.name}'; a name is a small letter and then small letters, digits and _, up to 40",
        )
    for key in ("symbol", "unit", "definition"):
        try:
            check_title(getattr(metric, key), key=key)
        except InputError as error:
            yield ContractViolation("", f"{key}: {error.message}")
    for key, allowed in CHOICES.items():
        if getattr(metric, key) not in allowed:
            yield ContractViolation(
                "", f"given {key} = {getattr(metric, key)!r}; allowed: {', '.join(map(repr, allowed))}"
            )
    if metric.is_binary and (metric.graded or metric.combine != "max"):
        yield ContractViolation(
            "", 'given is_binary with graded = True or another combine than "max"; a lost flight has 0 or 1 too'
        )
    for key in ("value", "bound"):
        if not callable(getattr(metric, key)):
            yield ContractViolation("", f"{key} must be a function of the view")


def accumulator_can_fly(metric: Metric) -> Iterator[ContractViolation]:
    """A record of numbers, and two functions that every backend can take."""
    accumulator: Any = metric.accumulator
    if accumulator is None:
        return
    if not isinstance(accumulator, Accumulator):
        yield ContractViolation("", f"given accumulator = {accumulator!r}; write Accumulator(Record, start, update)")
        return
    if not is_record(accumulator.Record) or not all(map(is_leaf, accumulator.Record.__annotations__.values())):
        yield ContractViolation(
            "Record",
            f"given {accumulator.Record!r}; write class {metric.name.title()}(NamedTuple) with numbers, such as sum: float",
        )
        return
    if accumulator.each_input and metric.scope != "flight":
        yield ContractViolation(
            "", 'given each_input with scope = "axis"; inputs belong to no axis: write scope="flight"'
        )
        return
    memory = accumulator.Record.__name__
    for name, arguments in _arguments(accumulator, metric).items():
        check_model_function(getattr(accumulator, name), name, arguments, "", memory)


def _arguments(accumulator: Accumulator, metric: Metric) -> dict[str, int]:
    if accumulator.each_input:
        return {"start": 1, "update": 3}
    return {"start": 2, "update": 5 if metric.scope == "axis" else 4}


def values_are_right(metric: Metric) -> Iterator[ContractViolation]:
    """Yield the violations of a metric's values on flights inside the limits.

    They are finite, at least 0 and at most the bound, and the same when asked again.
    """
    for view in _views(metric):
        value, bound = (_array(function(view)) for function in (metric.value, metric.bound))
        if not np.isfinite(bound).all() or not (bound > 0.0).all():
            yield ContractViolation("bound", f"gives {_worst(bound)}; it must be finite and above 0")
            return
        if not np.isfinite(value).all():
            yield ContractViolation("value", "is not finite for a flight that was completed")
            return
        if not (value >= 0.0).all():
            yield ContractViolation(
                "value", f"gives {float(value.min(axis=0)):g}; a metric is at least 0, and smaller is better"
            )
        if not (value <= np.minimum(bound, metric.highest) * (1.0 + 1e-12)).all():
            over = float((value / bound).max(axis=0))
            yield ContractViolation(
                "bound",
                f"is exceeded {over:.3g} times by a flight inside the limits; a lost flight must cost more than any",
            )
        if metric.is_binary and not (np.isin(value, (0.0, 1.0)).all() and (bound == 1.0).all()):
            yield ContractViolation("value", "is not 0 or 1 with a bound of 1, though is_binary says so")
        if not np.array_equal(value, _array(metric.value(view))):
            yield ContractViolation("value", "gives another number when it is asked again")


def _array(value: Any) -> NDArray[np.float64]:
    return np.broadcast_to(np.asarray(value, dtype=float), (FLIGHTS,))


def _worst(bound: NDArray[np.float64]) -> str:
    return f"{float(bound.min(axis=0)):g}"


def _views(metric: Metric) -> Iterator[AxisView | FlightView]:
    if metric.accumulator is not None:
        yield from sampled_views(metric, Plan(FLIGHTS, DURATION, PERIOD, _targets(), LIMITS))
        return
    meters, targets = unpack(Meters, _flights()), _targets()
    status, end = np.full(FLIGHTS, COMPLETED), np.full(FLIGHTS, DURATION)
    context = FlightContext(DURATION, PERIOD, targets, status, end, LIMITS)
    if metric.scope == "flight":
        yield FlightView(meters, context)
        return
    for axis in AXES:
        limit = LIMITS.position_error if UNITS[axis] == "m" else LIMITS.angle
        yield AxisView(getattr(meters, axis), getattr(targets, axis), limit, context)


def _targets() -> Targets:
    stepping, resting = (Target(0.0, level, 0.2, 0.05, 0.5, 0.05, 1.6) for level in (0.5, 0.0))
    return Targets(stepping, stepping, stepping, stepping, stepping, resting)


def _flights() -> NDArray[np.float64]:
    """Return meters (flights, columns) as flights inside the limits leave them: random, and the first at every limit."""
    rng = np.random.default_rng(7)
    rows = np.empty((FLIGHTS, len(COLUMNS)))
    for axis in AXES:
        limit = LIMITS.position_error if UNITS[axis] == "m" else LIMITS.angle
        for name, column in _axis_meters(rng, limit).items():
            rows[:, COLUMNS[f"{axis}.{name}"]] = column
    size = _sizes(rng)
    rows[:, COLUMNS["travel"]] = size * 4.0 * LIMITS.command_peak * DURATION / PERIOD
    rows[:, COLUMNS["effort"]] = size * 4.0 * (LIMITS.command_peak - 1.0) ** 2 * DURATION
    rows[:, COLUMNS["saturated"]] = size * DURATION
    rows[:, COLUMNS["command_peak"]] = size * LIMITS.command_peak
    return rows


def _sizes(rng: np.random.Generator) -> NDArray[np.float64]:
    """Return sizes (flights,) from 0 to 1; the first is 1."""
    sizes = rng.uniform(size=FLIGHTS) ** 3
    sizes[0] = 1.0
    return sizes


def _axis_meters(rng: np.random.Generator, limit: float) -> dict[str, NDArray[np.float64]]:
    """Return the meters of one axis with an error of constant size."""
    size, error = _sizes(rng), limit * _sizes(rng)
    late = 0.2 + size * (DURATION - 0.2)
    meters = {
        "itae": 0.5 * error * DURATION * (DURATION - PERIOD),
        "iae": error * DURATION,
        "ise": error**2 * DURATION,
        "peak": error,
        "overshoot_extreme": error * size,
        "rise_low_time": np.full(FLIGHTS, 0.2),
        "rise_high_time": late,
        "previous": error,
        "last_outside": late,
        "last_unrecovered": np.maximum(late, 0.5),
        "steady_sum": error * 0.4,
    }
    assert set(meters) == set(AxisMeter._fields), "every meter has values"
    return meters
