"""What every metric promises: a documented number, finite for any flight, and worse for a failed one than any other."""

from dataclasses import replace
from itertools import product
from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from objectives.metrics import (
    COMPLETED,
    METRICS,
    FlightContext,
    MetricLimits,
    all_addresses,
    parse,
    unpack,
)
from objectives.metrics.metric import COMBINE, AxisView, FlightView
from plant.vectors import Rotors
from tests.objectives.flying import (
    AXES,
    METERS,
    WIDTH,
    H,
    Signal,
    completed,
    evaluate,
    fly,
    rows,
    target,
    targets,
)

DURATION = 30 * H
LIMITS = MetricLimits(position_error=5.0, command_peak=3.0)
LARGEST = {axis: LIMITS.position_error if axis in ("x", "y", "z") else LIMITS.angle for axis in AXES}
AIMS = targets(
    x=target(0.0, 1.0, 5 * H, 0.05, 10 * H, 0.05, 15 * H),
    z=target(3.0, 2.0, 0.0, 0.05, 10 * H, 0.05, 15 * H),
    roll=target(0.0, 0.3, 0.0, 0.01, 10 * H, 0.02, 15 * H),
    yaw=target(0.0, 0.0, 0.0, 0.01, 28 * H, 0.02, 29 * H),
)


def against(error: dict[str, list[float]]) -> dict[str, Signal]:
    """Return signals with given errors at the instants, on references that step as `AIMS` say."""

    def signal(axis: str) -> Signal:
        aim = getattr(AIMS, axis)

        def at(t: float) -> tuple[float, float]:
            reference = aim.final if t >= aim.time - 1e-9 else aim.start
            return reference, reference - error[axis][round(t / H)]

        return at

    return {axis: signal(axis) for axis in AXES}


def random_flight(rng: np.random.Generator) -> Any:
    """Return the meters of a flight with random errors and commands inside the limits, some of them small."""
    errors = {axis: list(LARGEST[axis] * rng.uniform() ** 3 * rng.uniform(-1.0, 1.0, 31)) for axis in AXES}
    commands = [Rotors(*rng.uniform(0.0, LIMITS.command_peak, 4)) for _ in range(31)]
    limited = rng.integers(2, size=31)
    return fly(against(errors), AIMS, DURATION, H, lambda k: commands[k], lambda k: float(limited[k]))


def extreme_flight(sign: float) -> Any:
    """Return the meters of a flight at its limits from the first to the last instant."""
    errors = {axis: [sign * LARGEST[axis]] * 31 for axis in AXES}
    peak = LIMITS.command_peak
    ends = Rotors(peak, peak, peak, peak), Rotors(0.0, 0.0, 0.0, 0.0)
    return fly(against(errors), AIMS, DURATION, H, lambda k: ends[k % 2], lambda k: 1.0)


def make_flights() -> NDArray[np.float64]:
    """Return 20 random and 2 extreme flights (22, columns)."""
    rng = np.random.default_rng(11)
    return rows(*(random_flight(rng) for _ in range(20)), extreme_flight(1.0), extreme_flight(-1.0))


FLIGHTS = make_flights()
COMPLETE = completed(AIMS, DURATION, (len(FLIGHTS),), limits=LIMITS)


def failing(end_times: NDArray[np.float64]) -> FlightContext:
    """Return the context of failed flights."""
    return replace(COMPLETE, status=np.full(end_times.shape, COMPLETED + 2), end_time=end_times)


@pytest.mark.parametrize("name", METRICS)
def test_is_documented(name: str) -> None:
    metric = METRICS[name]
    assert metric.name == name
    assert metric.symbol and metric.unit
    assert len(metric.definition) > 10 and "\n" not in metric.definition
    assert metric.unit == "1" or "{}" in metric.unit or metric.unit in ("s", "1/s", "%")


@pytest.mark.parametrize("address", all_addresses())
def test_completed_flights_respect_the_bound_without_being_held_to_it(address: str) -> None:
    values = evaluate([parse(address)], FLIGHTS, COMPLETE).values
    assert values.shape == (1, len(FLIGHTS))
    assert np.all(np.isfinite(values))
    where, meters = parse(address), unpack(METERS.Meters, FLIGHTS)
    if where.axes:
        parts = [
            AxisView(
                getattr(meters, a),
                getattr(AIMS, a),
                LARGEST[a],
                COMPLETE,
                None if where.metric.accumulator is None else getattr(meters, where.metric.meter_name(a)),
            )
            for a in where.axes
        ]
    else:
        own = None if where.metric.accumulator is None else getattr(meters, where.metric.meter_name())
        parts = [FlightView(meters, COMPLETE, own)]
    formula = COMBINE[where.metric.combine](np.stack([where.metric.value(part) for part in parts], axis=0))
    # Flights at the limit may be held to the bound by the rounding of 30 sums, some 1e-15, and by no more.
    np.testing.assert_allclose(values[0], formula, rtol=1e-13)


@pytest.mark.parametrize("address", all_addresses())
def test_the_natural_range_holds_and_is_reached(address: str) -> None:
    """A flight without error whose rotors stand at hover has 0 of what can be 0; what cannot is above 0 in flight."""
    metric = parse(address).metric
    values = evaluate([parse(address)], FLIGHTS, COMPLETE).values
    assert np.all(values <= metric.highest)
    if metric.reaches_zero:
        still = {axis: [0.0] * 31 for axis in AXES}
        calm = rows(fly(against(still), AIMS, DURATION, H, lambda k: Rotors(1.0, 1.0, 1.0, 1.0), lambda k: 0.0))
        assert evaluate([parse(address)], calm, completed(AIMS, DURATION, (1,), limits=LIMITS)).values[0] == 0.0
    elif metric.name != "rise":  # These flights jump from here to there, which no vehicle does.
        assert np.all(values[:, :20] > 0.0)


@pytest.mark.parametrize("address", all_addresses())
def test_failed_flights_cost_more_than_any_completed_and_less_the_longer_they_last(address: str) -> None:
    worst = np.max(evaluate([parse(address)], FLIGHTS, COMPLETE).values)
    junk = np.full((5, WIDTH), [[np.nan], [np.inf], [-np.inf], [1e300], [0.0]])
    costs = evaluate([parse(address)], junk, failing(np.array([0.0, H, 0.5 * DURATION, DURATION - H, DURATION]))).values
    assert np.all(np.isfinite(costs))
    assert np.min(costs) > worst
    if METRICS[parse(address).metric.name].graded:
        assert np.all(np.diff(costs, axis=-1) < 0.0)
        assert costs[0, 0] < 2.0 * costs[0, -1]  # from twice the bound to just above it
    else:
        assert np.all(costs == 1.0)


@pytest.mark.parametrize(
    ("address", "bound"),
    [
        ("itae.x", 5.0),
        ("iae.roll", pi * DURATION),
        ("ise.z", 25.0 * DURATION),
        ("rms.horizontal", 5.0 * sqrt(2.0)),
        ("peak.attitude", pi),
        ("itae.tilt", 2.0 * pi),
        ("overshoot.z", 500.0),
        ("overshoot.roll", 100.0 * pi / 0.3),
        ("overshoot.yaw", 100.0),
        ("rise.x", DURATION),
        ("settling.yaw", DURATION),
        ("recovery.attitude", DURATION),
        ("steady_error.y", 5.0),
        ("travel", 12.0 / H),
        ("effort", 16.0),
        ("saturation", 1.0),
        ("command_peak", 3.0),
        ("noise", 6.0),
        ("step_itae.x", 0.5 * 5.0 * (25 * H) ** 2),
        ("final_overshoot.z", 200.0 * 5.0 / 0.1),
    ],
)
def test_a_failure_halfway_costs_one_and_a_half_bounds(address: str, bound: float) -> None:
    cost = evaluate([parse(address)], FLIGHTS[0], failing(np.array(0.5 * DURATION))).values[0]
    # 2 - 15/31 instead of 1.5: the planned 30 periods count as 31, so that a failure at the very end still costs more.
    assert cost == pytest.approx(bound * (2.0 - 15.0 / 31.0), rel=1e-12)


@pytest.mark.parametrize("address", all_addresses())
def test_end_times_outside_the_flight_count_as_its_ends(address: str) -> None:
    costs = evaluate([parse(address)], FLIGHTS[:4], failing(np.array([-1.0, 0.0, DURATION, 9.0]))).values[0]
    assert costs[0] == costs[1] and costs[2] == costs[3]


@pytest.mark.parametrize("junk", [np.nan, np.inf, -np.inf])
def test_a_completed_flight_without_a_finite_value_costs_like_a_failed_one(junk: float) -> None:
    broken = np.full((1, WIDTH), junk)
    for address in map(parse, ("rms.x", "peak.tilt", "travel")):
        alone = replace(COMPLETE, status=np.array([COMPLETED]), end_time=np.array([DURATION]))
        values = evaluate([address], broken, alone).values
        assert np.all(np.isfinite(values))
        assert values[0, 0] > np.max(evaluate([address], FLIGHTS, COMPLETE).values)


@pytest.mark.parametrize("address", all_addresses())
def test_a_batch_is_its_flights_one_by_one(address: str) -> None:
    status = np.arange(6).reshape(2, 3) % 2
    mixed = replace(COMPLETE, status=status, end_time=np.where(status == COMPLETED, DURATION, 0.3 * DURATION))
    batch = FLIGHTS[:6].reshape(2, 3, -1)
    together = evaluate([parse(address)], batch, mixed)
    for i, j in product(range(2), range(3)):
        own = replace(mixed, status=mixed.status[i, j], end_time=mixed.end_time[i, j])
        alone = evaluate([parse(address)], batch[i, j], own)
        assert together.values[0, i, j] == alone.values[0]
        assert together.censored[0, i, j] == alone.censored[0]


@pytest.mark.parametrize("address", [a for a in all_addresses() if METRICS[a.split(".")[0]].censored])
def test_failed_flights_are_censored(address: str) -> None:
    failed = failing(np.full(len(FLIGHTS), 0.5 * DURATION))
    assert np.all(evaluate([parse(address)], FLIGHTS, failed).censored)


def test_rows_follow_the_addresses() -> None:
    names = ["travel", "itae.x", "failure", "itae.x", "peak.attitude"]
    together = evaluate([parse(name) for name in names], FLIGHTS, COMPLETE).values
    for row, name in enumerate(names):
        np.testing.assert_array_equal(together[row], evaluate([parse(name)], FLIGHTS, COMPLETE).values[0])


def test_status_decides_and_not_the_meters() -> None:
    status = np.arange(len(FLIGHTS)) % 3
    mixed = replace(COMPLETE, status=status, end_time=np.where(status == COMPLETED, DURATION, 0.0))
    values = evaluate([parse("failure"), parse("iae.z")], FLIGHTS, mixed).values
    np.testing.assert_array_equal(values[0], status != COMPLETED)
    np.testing.assert_allclose(values[1, status != COMPLETED], 2.0 * LIMITS.position_error * DURATION, rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("itae", 7.0 * 29 / 30),
        ("iae", 7.0 * DURATION),
        ("ise", 25.0 * DURATION),
        ("rms", 5.0),
        ("peak", 4.0),
        ("steady_error", 5.0),
    ],
)
def test_groups_combine_errors_of_3_and_4(name: str, expected: float) -> None:
    aims = targets()
    flight = rows(
        fly({"x": lambda t: (0.0, 3.0), "y": lambda t: (0.0, -4.0), "roll": lambda t: (0.0, 1.0)}, aims, DURATION)
    )
    context = completed(aims, DURATION)
    for group, value in {"horizontal": expected, "position": expected}.items():
        assert evaluate([parse(f"{name}.{group}")], flight, context).values[0, 0] == pytest.approx(value, rel=1e-12)
    alone, tilt, attitude = (
        evaluate([parse(f"{name}.{axes}")], flight, context).values for axes in ("roll", "tilt", "attitude")
    )
    assert alone == tilt == attitude > 0.0


def test_times_of_a_group_are_those_of_its_slowest_axis() -> None:
    aims = targets(x=target(time=2 * H), y=target(time=0.0))
    flight = rows(
        fly({"x": lambda t: (0.0, float(t < 9.5 * H)), "y": lambda t: (0.0, float(t < 4.5 * H))}, aims, DURATION)
    )
    context = completed(aims, DURATION)
    scores = evaluate([parse("settling.horizontal"), parse("settling.y")], flight, context)
    np.testing.assert_allclose(scores.values[:, 0], [8 * H, 5 * H], rtol=1e-9)
    never = rows(fly({"y": lambda t: (0.0, 1.0)}, aims, DURATION))
    np.testing.assert_array_equal(
        evaluate([parse("settling.horizontal"), parse("settling.x")], never, context).censored[:, 0], [True, False]
    )


def test_targets_may_differ_between_flights() -> None:
    steps = [1.0, -2.0]
    flights, expected = [], []
    for step in steps:
        aims = targets(z=target(0.0, step))
        flights.append(fly({"z": lambda t, s=step: (s, 1.1 * s)}, aims, DURATION))
        expected.append(10.0)
    both = targets(z=target()._replace(final=np.array(steps)))
    values = evaluate([parse("overshoot.z")], rows(*flights), completed(both, DURATION, (2,))).values
    np.testing.assert_allclose(values, [expected], rtol=1e-9)
