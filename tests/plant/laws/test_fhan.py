"""fhan as the sampled time-optimal law that it claims to be, with the mistakes of published copies refused; the differentiator."""

from collections.abc import Callable
from functools import partial
from math import sqrt

import numpy as np
import pytest

from plant.backends import array
from plant.laws.channel import Setpoint
from plant.laws.fhan import fhan
from plant.laws.tracking_differentiator import Profile, track
from tests.plant.harness import Array

Law = Callable[[Array, Array, float, float], Array]
R, H = 4.0, 0.01
# How far 0 may be passed, and what counts as rest: between the samples that it is exact for, fhan brakes late by up to r h^2/8.
PASSING, REST = 0.125001 * R * H * H, 1e-14
on_arrays: Law = array.rebinder()(fhan)


def older_form(x1: Array, x2: Array, r: float, h: float) -> Array:
    """The form that came before fhan's: with d = r h in rates in place of d = r h^2 in positions."""
    d, y = r * h, x1 + h * x2
    a0 = np.sqrt(d * d + 8.0 * r * np.abs(y))
    a = np.where(np.abs(y) > h * d, x2 + np.sign(y) * (a0 - d) / 2.0, x2 + y / h)
    return np.where(np.abs(a) > d, -r * np.sign(a), -r * a / d)


def published(x1: Array, x2: Array, r: float, h: float, mistake: str) -> Array:
    """Forms as they stand in public code, with one mistake each; "none" is the form without any."""
    d, a0 = r * h * h, h * x2
    y = x1 + a0
    inside = np.sign(y) if mistake == "sign for size" else np.abs(y)
    a1 = np.sqrt(np.abs(d * (d + 8.0 * inside)))
    a2 = a0 + (1.0 if mistake == "no sign" else np.sign(y)) * (a1 - d) / 2.0
    a = (a0 + y - a2) * (np.sign(y + d) - np.sign(y - d)) / 2.0 + a2
    of = y if mistake == "wrong zone" else a
    return -r * (a / d - np.sign(a)) * (np.sign(of + d) - np.sign(of - d)) / 2.0 - r * np.sign(a)


MISTAKES = ("no sign", "wrong zone", "sign for size")


def starts(count: int) -> tuple[Array, Array]:
    """Positions and rates from far outside to far inside the linear zone, whose size is r h^2 = 4e-4 and r h = 0.04."""
    rng = np.random.default_rng(1)
    x1 = rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-6.0, 0.5, count)
    x2 = rng.choice([-1.0, 0.0, 1.0], count) * 10.0 ** rng.uniform(-5.0, 0.5, count)
    return x1, x2


def shortest_time(x1: Array, x2: Array) -> Array:
    """Time to rest at 0 of the continuous double integrator with |u| <= r: full one way, full the other way."""
    ahead = np.where(x1 + x2 * np.abs(x2) / (2.0 * R) >= 0.0, 1.0, -1.0)
    return ahead * x2 / R + 2.0 * np.sqrt(np.maximum(x2**2 / (2.0 * R**2) + ahead * x1 / R, 0.0))


def faults(law: Law) -> list[str]:
    """What the law does wrong, in words; empty for a time-optimal one."""
    found = []
    x1, x2 = starts(2000)
    due = shortest_time(x1, x2) / H
    crossings, late, over = np.zeros(len(x1)), np.zeros(len(x1)), 0.0
    for k in range(int(due.max(axis=0)) + 40):
        u = law(x1, x2, R, H)
        over = max(over, float(np.nanmax(np.abs(u), axis=0, initial=0.0)) - R)
        late = np.where(np.maximum(np.abs(x1), H * np.abs(x2)) < REST, late, k + 1 - due)
        x1, x2, before = x1 + H * x2, x2 + H * u, x1
        crossings += (np.sign(before) * x1 < 0.0) & (np.abs(x1) > PASSING)
    if over > 1e-12 * R or not np.isfinite(x1).all():
        found.append("asks for more than r")
    if late.max(axis=0) > 12.0 or np.quantile(late, 0.995, axis=0) > 4.0:
        found.append("is not at rest in time")
    # A start that runs away from 0, or too fast towards it, may pass it once; no other may.
    if (crossings > 1.0).any():
        found.append("swings about 0")
    return found


def test_every_start_comes_to_rest_exactly_in_shortest_time_without_swinging() -> None:
    """A few periods after the time that no law can beat; more only on its braking parabola. Exact to rounding."""
    assert faults(on_arrays) == []


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_of_published_copies_are_refused(mistake: str) -> None:
    with np.errstate(invalid="ignore"):
        assert faults(partial(published, mistake=mistake)) != []


@pytest.mark.parametrize("other", [older_form, partial(published, mistake="none")], ids=["older", "published"])
def test_both_published_forms_are_the_same_function(other: Law) -> None:
    x1, x2 = starts(5000)
    for r, h in ((R, H), (400.0, 0.02), (0.5, 1.0)):
        # Rounding of a, some 1e-16 of a0 and y, over d.
        tolerance = 1e-13 * r * (1.0 + np.abs(x1) / (r * h * h) + np.abs(x2) / (r * h))
        assert (np.abs(on_arrays(x1, x2, r, h) - other(x1, x2, r, h)) <= tolerance).all()


def test_the_bound_holds_everywhere() -> None:
    rng = np.random.default_rng(2)
    for scale in (1e-300, 1e-12, 1.0, 1e12, 1e150):
        x1, x2 = scale * rng.standard_normal((2, 500))
        for r in (1e-3, 1.0, 1e6):
            assert (np.abs(on_arrays(x1, x2, r, H)) <= r).all()
    assert fhan(0.0, 0.0, R, H) == 0.0


@pytest.mark.parametrize(("filtering", "passing"), [(1.0, PASSING), (5.0, REST)])
def test_a_start_at_rest_does_not_pass_zero_by_more_than_an_eighth_of_the_zone(
    filtering: float, passing: float
) -> None:
    """The eighth is reached, and a longer period in fhan removes it."""
    x1, x2 = starts(2000)[0], np.zeros(2000)
    side, furthest = np.sign(x1), 0.0
    for _ in range(600):
        x1, x2 = x1 + H * x2, x2 + H * on_arrays(x1, x2, R, filtering * H)
        furthest = max(furthest, float((-side * x1).max(axis=0)))
    assert furthest <= passing
    assert furthest > 0.12 * R * H * H or filtering > 1.0


def follow(setpoints: list[Setpoint], r0: float, periods: float = 1.0, h: float = H) -> Array:
    """v1 and v2 (K, 2) of the differentiator for a sequence of setpoints, from rest at 0."""
    memory, rows = Profile(0.0, 0.0), []
    for setpoint in setpoints:
        now, memory = track(memory, setpoint, r0, periods * h, h)
        rows.append(now)
    return np.array(rows)


@pytest.mark.parametrize("size", [0.2, 1.0, 30.0])
@pytest.mark.parametrize("periods", [1.0, 5.0])
def test_a_step_is_passed_on_in_the_time_that_its_acceleration_allows(size: float, periods: float) -> None:
    """2 sqrt(R/r0), later by a few h0, never faster than r0 and not past it by more than fhan's eighth."""
    r0, least = 3.0, 2.0 * sqrt(size / 3.0)
    v1, v2 = follow([Setpoint(size, 0.0, 0.0)] * 1200, r0, periods).T
    arrival = H * float(np.nonzero(v1 < 0.999 * size)[0][-1] + 1)
    assert 0.95 * least < arrival < least + 6.0 * periods * H
    assert v1.max(axis=0) <= size * (1.0 + 1e-12) + (0.126 * r0 * H * H if periods == 1.0 else 0.0)
    assert np.abs(np.diff(v2)).max(axis=0) <= r0 * H * (1.0 + 1e-9)
    assert abs(v1[-1] - size) < 1e-12 and abs(v2[-1]) < 1e-12


def test_a_slow_ramp_comes_late_by_twice_the_filter_period_unless_its_rate_is_known() -> None:
    ramp = [Setpoint(0.5 * k * H, 0.0, 0.0) for k in range(800)]
    v1, v2 = follow(ramp, 50.0, 5.0).T
    assert (ramp[-1].value - v1[-1]) / 0.5 == pytest.approx(
        2.0 * 5.0 * H, rel=0.11
    )  # less one period: news is not kept
    assert v2[-1] == pytest.approx(0.5, abs=1e-9)
    known = [setpoint._replace(rate=0.5) for setpoint in ramp]
    v1, _ = follow(known, 50.0, 5.0).T
    assert v1[-1] == pytest.approx(ramp[-1].value, abs=1e-12)


def test_a_moving_reference_is_joined_and_then_passes_unchanged() -> None:
    """About a reference of constant acceleration the deviation obeys Han's recursion, so it is gone in 2 sqrt(R/r0)."""
    path = [Setpoint(2.0, -1.0, 0.7)]
    for _ in range(600):
        y, v, a = path[-1]
        path.append(Setpoint(y + H * v + 0.5 * H * H * a, v + H * a, a))
    v1, v2 = follow(path, 8.0).T
    away = np.array([point.value for point in path]) - v1
    assert away.min(axis=0) > -0.126 * 8.0 * H * H
    arrived = round((2.0 * sqrt(2.0 / 8.0) + 1.0 / 8.0) / H) + 6
    np.testing.assert_allclose(away[arrived:], 0.0, atol=1e-9)
    np.testing.assert_allclose(v2[arrived:], [point.rate for point in path[arrived:]], atol=1e-9)
