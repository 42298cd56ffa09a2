"""Absolute stability of the hybrid against the frequency domain and against flights of the law itself."""

from dataclasses import replace
from math import sqrt
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from objectives.linear_axis.channel_model import WITH_SECTOR, AxisLoop, TiltLoop, closed_loop, sector
from plant.laws import hybrid
from plant.laws.hybrid import sliding_term
from tests.objectives.linear_axis.cases import HYBRID, LADRC, ROTORS, Array, is_negative
from tuner.extensions.certificates.circle_criterion import run

AXES = {
    "measured rate": HYBRID,
    "observed rate": replace(HYBRID, from_observer=True),
    "lag unknown": replace(HYBRID, actuator=replace(ROTORS, lag_aware=False)),
    "fast observer": replace(HYBRID, gains=hybrid.Gains(40.0, 3.0, 6.0, 8.0, 0.1)),
    "horizontal": AxisLoop("hybrid", hybrid.Gains(4.0, 1.0, 0.5, 1.0, 0.2), TiltLoop(LADRC), "position"),
}


def response(axis: AxisLoop, omega: Array) -> Any:
    """S over -phi at frequencies: the linear part as the criterion sees it, state space solved frequency by frequency."""
    a, b, s = closed_loop(axis).channel("power", "sliding")
    resolvent = 1j * omega[:, None, None] * np.eye(len(a)) - a
    return -(s @ np.linalg.solve(resolvent, np.broadcast_to(b, (len(omega), *b.shape))))[:, 0, 0]


def circle(axis: AxisLoop) -> float:
    """Largest kappa with 1 + kappa Re G(jw) > 0 on a dense grid, refined around its worst frequency."""
    omega = np.geomspace(1e-2, 1e4, 6001)
    worst = omega[response(axis, omega).real.argmin(axis=0)]
    near = worst * np.geomspace(0.997, 1.003, 601)
    return float(-1.0 / response(axis, near).real.min(axis=0))


def linear_limit(axis: AxisLoop) -> float:
    """Smallest gain in place of phi at which the loop is no longer stable."""
    a, b, s = closed_loop(axis).channel("power", "sliding")
    gains = np.geomspace(1.0, 1e4, 1001)
    stable = np.array([np.linalg.eigvals(a + k * b @ s).real.max(axis=0) < 0.0 for k in gains])
    return float(gains[np.argmin(stable)])


@pytest.mark.parametrize("name", AXES)
def test_circle_criterion_is_its_frequency_condition(name: str) -> None:
    found = run(AXES[name], popov=False)
    assert found.verified and found.value is not None
    assert (1.0 - 2e-3) * circle(AXES[name]) < found.value < (1.0 + 1e-6) * circle(AXES[name])


@pytest.mark.parametrize("name", AXES)
def test_popov_lies_between_circle_and_linear_limit(name: str) -> None:
    """Less conservative than the circle; no criterion reaches beyond the linear loops of the sector (to the grid's 0.93 %)."""
    found = run(AXES[name])
    assert found.verified and found.value is not None
    assert circle(AXES[name]) < found.value < 1.0093 * linear_limit(AXES[name])


@pytest.mark.parametrize("name", AXES)
def test_popov_multiplier_keeps_its_frequency_condition(name: str) -> None:
    """1/kappa + Re((1 + j w eta) G(jw)) > 0 with the eta that was found."""
    found = run(AXES[name])
    assert found.value is not None
    omega = np.geomspace(1e-2, 1e4, 6001)
    multiplied = (1.0 + 1j * omega * found.data["eta"]) * response(AXES[name], omega)
    assert 1.0 / found.value + multiplied.real.min(axis=0) > -1e-6 / found.value


@pytest.mark.parametrize("popov", [False, True])
@pytest.mark.parametrize("name", AXES)
def test_the_function_falls_for_every_term_in_the_sector(name: str, popov: bool) -> None:
    """V' of x'Px + 2 eta int phi, in the loop's own coordinates, at random states and phi anywhere in the sector."""
    found = run(AXES[name], popov=popov)
    p, eta = found.data["P"], found.data["eta"]
    assert found.value is not None
    a, b, s = closed_loop(AXES[name]).channel("power", "sliding")
    x = np.random.default_rng(6).standard_normal((3000, len(a))) / np.sqrt(np.diag(p))
    sliding = (x @ s.T)[:, 0]
    assert is_negative(-p / np.sqrt(np.outer(np.diag(p), np.diag(p))))
    for share in (0.0, 0.2, 0.7, 1.0):
        phi = share * found.value * sliding
        rates = x @ a.T + np.outer(phi, b[:, 0])
        falling = np.einsum("ni,ij,nj->n", x, p, rates) + eta * phi * (rates @ s.T)[:, 0]
        assert falling.max(axis=0) < 0.0


def settles(axis: AxisLoop, size: float) -> bool:
    """Whether a flight of the law itself, from a sliding variable of that size, comes down to a hundredth of it."""
    loop = closed_loop(axis)
    power, s = loop.b[:, 2], loop.c[3]
    constants = hybrid.LAW.prepare(axis.gains, 0.004)

    def slopes(_: float, x: Array) -> Array:
        value = float(s @ x)
        return loop.a @ x + power * (sliding_term(value, constants) - axis.gains.k2 * value)

    x0 = np.zeros(len(loop.a))
    x0[1] = size
    flown = solve_ivp(slopes, (0.0, 8.0), x0, method="LSODA", max_step=0.05, rtol=1e-5, atol=1e-8 * size)
    return bool(np.abs(flown.y[:2, -1]).max(axis=0) < 0.01 * size)


@pytest.mark.parametrize("size", [0.02, 0.1, 1.0, 30.0])
def test_inside_the_sector_no_flight_diverges(size: float) -> None:
    limit = run(HYBRID).value
    assert limit is not None
    inside = replace(HYBRID, gains=HYBRID.gains._replace(k1=0.98 * limit * sqrt(HYBRID.gains.delta)))
    assert sector(inside) == pytest.approx(0.98 * limit)
    assert settles(inside, size)


def test_the_circle_is_conservative() -> None:
    """Beyond the circle's limit but inside Popov's, every flight settles all the same; far beyond both, one does not."""
    delta, limit = HYBRID.gains.delta, run(HYBRID, popov=False).value
    assert limit is not None
    beyond = replace(HYBRID, gains=HYBRID.gains._replace(k1=2.0 * limit * sqrt(delta)))
    assert all(settles(beyond, size) for size in (0.02, 0.1, 1.0, 30.0))
    # Where S is of the size of delta the gain is near its largest, and beyond the linear limit: a limit cycle.
    wild = replace(HYBRID, gains=HYBRID.gains._replace(k1=2.0 * linear_limit(HYBRID) * sqrt(delta)))
    assert not settles(wild, 0.1)


def test_what_it_says_of_the_given_gains() -> None:
    limit = run(HYBRID).value
    assert limit is not None
    for k1, kept in ((0.9 * limit, True), (1.1 * limit, False)):
        axis = replace(HYBRID, gains=HYBRID.gains._replace(k1=k1 * sqrt(HYBRID.gains.delta)))
        found = run(axis)
        assert found.value == pytest.approx(limit, rel=1e-9)
        assert found.data["given"] == pytest.approx(k1)
        assert found.data["kept"] is kept


@pytest.mark.parametrize("name", sorted(WITH_SECTOR))
def test_the_printed_variants_have_limits_of_their_own(name: str) -> None:
    axis = replace(HYBRID, law=name)
    found = run(axis, popov=False)
    assert found.value == pytest.approx(circle(axis), rel=2e-3)


def test_without_stability_at_small_amplitude_there_is_nothing() -> None:
    none = run(replace(HYBRID, gains=HYBRID.gains._replace(k2=400.0)))
    assert none.value is None and not none.verified and none.data["kept"] is False
    assert "k2" in none.why
