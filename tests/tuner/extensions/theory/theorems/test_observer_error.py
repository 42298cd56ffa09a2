"""Bounds on the observer's errors, against the exact L1 norms of the observer that flies."""

import numpy as np
import pytest

from plant.law_registry import LAWS
from plant.laws.observer import Observer, observe, observer_constants
from tuner.extensions.theory.theorems import THEOREMS, Setting
from tuner.extensions.theory.theorems.observer_error import (
    THREE_POLES,
    disturbance_bound,
    rate_bound,
    value_bound,
)

# Two-point Gauss-Legendre integrates polynomials up to the third degree exactly: kernels within a period are quadratic.
NODES = np.array([0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)])
INSIDE = np.linspace(0.0, 1.0, 41)


def error_map(omega_o, h):
    """Return the flown observer's map of errors: z minus the state it sees, over one period without disturbance."""
    constants = observer_constants(omega_o, h)
    return np.array([observe(Observer(*unit), constants, 0.0, 0.0, h) for unit in np.eye(3).tolist()]).T


def correction(omega_o, h):
    """Return I - l C: what is left of a deviation of the state right before the correction, by the flown observer."""
    constants = observer_constants(omega_o, h)
    # A prediction of 0 and a measurement of 1 is corrected by l; C picks the first component.
    gain = np.array(observe(Observer(0.0, 0.0, 0.0), constants, 1.0, 0.0, h))
    return np.eye(3) - np.outer(gain, [1.0, 0.0, 0.0])


def kernels(omega_o, h, share):
    """Return the responses (periods, 3, instants) of e to an impulse of d' at shares (instants,) of a period before its end."""
    left = share * h
    kick = correction(omega_o, h) @ np.stack([left**2 / 2.0, left, np.ones_like(left)])
    step, found = error_map(omega_o, h), []
    for _ in range(round(60.0 / (omega_o * h)) + 5):
        found.append(kick)
        kick = step @ kick
    return np.array(found)


def l1_norms(omega_o, h):
    """Return the L1 norms (3,) of the errors right after a measurement for |d'| <= 1; every kernel is checked for its sign."""
    size = np.abs(kernels(omega_o, h, INSIDE)).max(axis=(0, 2), keepdims=True)
    assert (kernels(omega_o, h, INSIDE) / size).min() > -1e-9
    return 0.5 * h * np.abs(kernels(omega_o, h, NODES)).sum(axis=(0, 2))


@pytest.mark.parametrize("product", [0.01, 0.1, 0.3, 1.0])
@pytest.mark.parametrize("h", [0.001, 0.004])
def test_bounds_are_the_l1_norms_of_the_observer_that_flies(product, h):
    omega_o, setting = np.array(product / h), Setting(h, 7.0)
    held = l1_norms(product / h, h)[2] + h  # z3 stands still while d moves on by h at most
    found = [value_bound(omega_o, setting), rate_bound(omega_o, setting), disturbance_bound(omega_o, setting)]
    # The last entries of the sum are below exp(-60) of the first; rounding in (1 - beta)^3 / h^2 is the rest.
    np.testing.assert_allclose(found, 7.0 * np.array([*l1_norms(product / h, h)[:2], held]), rtol=1e-7)


def continuous_bounds(omega_o, rate):
    """Bounds on |e1|, |e2| and |e3| of the continuous observer: the limit for h -> 0."""
    return rate / omega_o**3, 3.0 * rate / omega_o**2, 3.0 * rate / omega_o


def test_how_far_off_the_continuous_formula_is_at_the_fastest_observer_admitted():
    # wo h = 0.3: the numbers that the module states; for h -> 0 the two agree, to first order in wo h.
    omega_o, h = np.array(75.0), 0.004
    setting = Setting(h, 1.0)
    sampled = np.array(
        [value_bound(omega_o, setting), rate_bound(omega_o, setting), disturbance_bound(omega_o, setting)]
    )
    ratio = sampled / np.array(continuous_bounds(omega_o, 1.0))
    np.testing.assert_allclose(ratio, [0.631, 0.874, 1.057], atol=6e-4)
    assert l1_norms(75.0, h)[2] * 75.0 / 3.0 == pytest.approx(0.957, abs=6e-4)
    fine = Setting(1e-6, 1.0)
    limit = np.array([value_bound(omega_o, fine), rate_bound(omega_o, fine), disturbance_bound(omega_o, fine)])
    np.testing.assert_allclose(limit / np.array(continuous_bounds(omega_o, 1.0)), 1.0, atol=3e-4)


def follow(omega_o, h, slopes):
    """Run the flown observer on y'' = d, d' constant over each period; errors after each measurement and d - z3 at its end."""
    state, z, constants = np.zeros(3), Observer(0.0, 0.0, 0.0), observer_constants(omega_o, h)
    move = np.array([[1.0, h, h * h / 2.0], [0.0, 1.0, h], [0.0, 0.0, 1.0]])
    push = np.array([h**3 / 6.0, h * h / 2.0, h])
    errors, held = [], []
    for slope in slopes:
        state = move @ state + slope * push
        held.append(state[2] - z.z3)
        z = observe(z, constants, float(state[0]), 0.0, h)
        errors.append(state - np.array(z))
    return np.array(errors), np.array(held)


@pytest.mark.parametrize("omega_o", [5.0, 75.0])
def test_a_ramp_of_disturbance_reaches_every_bound(omega_o):
    # T8, equality.
    h, rate = 0.004, 4.0
    errors, held = follow(omega_o, h, [rate] * round(40.0 / (omega_o * h)))
    setting, wo = Setting(h, rate), np.array(omega_o)
    reached = [*errors[-1][:2], held[-1]]
    expected = [value_bound(wo, setting), rate_bound(wo, setting), disturbance_bound(wo, setting)]
    np.testing.assert_allclose(reached, expected, rtol=1e-6)


def test_no_disturbance_of_bounded_rate_exceeds_them():
    h, setting, rng = 0.004, Setting(0.004, 1.0), np.random.default_rng(8)
    wo = np.array(30.0)
    for hold in (1, 10, 60):
        errors, held = follow(30.0, h, np.repeat(rng.choice([-1.0, 1.0], 6000 // hold), hold).tolist())
        worst = [*np.abs(errors).max(axis=0)[:2], np.abs(held).max(axis=0)]
        bounds = np.array([value_bound(wo, setting), rate_bound(wo, setting), disturbance_bound(wo, setting)])
        assert (worst <= bounds * (1.0 + 1e-9)).all()


def places_three_poles(law):
    gains = law.Gains(**law.defaults("attitude"))
    if not hasattr(gains, "omega_o"):
        return False
    return getattr(law.prepare(gains, 0.004), "observer", None) == observer_constants(gains.omega_o, 0.004)


def test_they_are_offered_for_exactly_the_laws_with_that_observer():
    assert {name for name, law in LAWS.items() if places_three_poles(law)} == set(THREE_POLES)
    for name in ("observer_value", "observer_rate", "observer_disturbance"):
        assert set(THEOREMS[name].laws) == set(THREE_POLES)
        assert THEOREMS[name].needs_rate and THEOREMS[name].speaks_of("ladrc", rate_from_observer=True)
