"""Describing functions: constants known in closed form, and SciPy's quadrature on the terms of every law."""

from math import gamma, pi, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from objectives.margins.describing import Case, describing_function, steepest_slope, term_gains
from objectives.margins.period import constants_of, terms_of
from plant.law_registry import LAWS
from plant.laws import hybrid
from plant.records import pack
from tests.objectives.margins.designs import H, cascade_of, default_gains, gains_with

AMPLITUDES = np.geomspace(1e-3, 30.0, 19)
TERMS = [(name, entry) for name, law in LAWS.items() for entry in law.nonlinear]


def constants(name, attitude=True):
    """Default constants of a law in one loop, as arrays and as floats."""
    gains = default_gains(name, name)[None]
    own = constants_of(cascade_of(name, name), gains, H)
    plain = cascade_of(name, name).prepare(pack(cascade_of(name, name).Gains, gains[0].tolist()), H)
    return (own.roll, plain.roll) if attitude else (own.x, plain.x)


def power_rate(delta):
    """Constants of |s|^(1/2) sat(s/delta) alone."""
    gains = gains_with("hybrid", "hybrid", roll__k1=1.0, roll__k2=0.0, roll__delta=delta)
    return constants_of(cascade_of("hybrid", "hybrid"), gains, H).roll


def test_power_rate_term_has_the_constants_of_its_closed_form():
    """N(A) = 2/sqrt(pi) G(7/4)/G(9/4) A^(1/2)/delta inside, tends to 2/sqrt(pi) G(5/4)/G(7/4) A^(-1/2) far outside."""
    inside, outside = 2.0 / sqrt(pi) * gamma(1.75) / gamma(2.25), 2.0 / sqrt(pi) * gamma(1.25) / gamma(1.75)
    assert (inside, outside) == (pytest.approx(0.915312, abs=5e-7), pytest.approx(1.112836, abs=5e-7))
    delta, a = 0.2, np.array([1e-4, 0.01, 0.19])
    within = describing_function(hybrid.sliding_term, power_rate(delta), a)[0]
    np.testing.assert_allclose(within * delta / np.sqrt(a), inside, rtol=1e-6)
    beyond = describing_function(hybrid.sliding_term, power_rate(delta), np.array([1e5]))[0]
    np.testing.assert_allclose(beyond * np.sqrt(1e5), outside, rtol=1e-5)


def test_power_rate_term_is_largest_a_little_beyond_its_corner():
    relative = np.linspace(0.9, 1.3, 401)
    n = describing_function(hybrid.sliding_term, power_rate(0.05), 0.05 * relative)[0] * sqrt(0.05)
    assert n.max(axis=0) == pytest.approx(0.92653, abs=1e-4)
    assert relative[np.argmax(n)] == pytest.approx(1.08, abs=0.01)
    table = {0.01: 0.0915, 0.1: 0.2895, 0.5: 0.6472, 1.0: 0.9153, 2.0: 0.7678, 10.0: 0.3518, 100.0: 0.1113}
    found = describing_function(hybrid.sliding_term, power_rate(0.05), 0.05 * np.array(list(table)))[0] * sqrt(0.05)
    np.testing.assert_allclose(found, list(table.values()), atol=1e-4)


def test_steepest_slope_of_the_power_rate_term_stands_at_its_corner():
    """f' = 1.5 |s|^(1/2)/delta just inside the corner, wherever that stands between the points of the grid."""
    for delta in np.geomspace(0.01, 1.0, 23).tolist():
        assert steepest_slope(hybrid.sliding_term, power_rate(delta))[0] == pytest.approx(1.5 / sqrt(delta), rel=3e-7)


@pytest.mark.parametrize(("name", "entry"), TERMS, ids=[f"{name}-{entry.name}" for name, entry in TERMS])
def test_steepest_slope_of_every_term_is_what_an_optimiser_finds(name, entry):
    arrays, plain = constants(name)

    def slope(log_s):
        s = float(np.exp(log_s))
        return (entry.function(s * (1.0 + 1e-7), plain) - entry.function(s * (1.0 - 1e-7), plain)) / (2e-7 * s)

    scan = np.linspace(np.log(1e-6), np.log(100.0 * (1.0 - 1e-7)), 2001)
    best = scan[int(np.argmax([slope(x) for x in scan]))]
    width = scan[1] - scan[0]
    found: Any = minimize_scalar(
        lambda x: -slope(x),
        bounds=(best - width, min(best + width, scan[-1])),
        method="bounded",
        options={"xatol": 1e-12},
    )
    # What rises steeper still at 0, as a root does, counts over the width of rest.
    at_rest = entry.function(1e-9, plain) / 1e-9
    assert steepest_slope(entry.function, arrays)[0] == pytest.approx(max(-found.fun, slope(best), at_rest), rel=1e-6)


@pytest.mark.parametrize("attitude", [True, False], ids=["attitude", "position"])
@pytest.mark.parametrize(("name", "entry"), TERMS, ids=[f"{name}-{entry.name}" for name, entry in TERMS])
def test_terms_of_every_law_against_quadrature(name, entry, attitude):
    arrays, plain = constants(name, attitude)
    found = describing_function(entry.function, arrays, AMPLITUDES)[0]

    def exact(a):
        whole, _ = quad(
            lambda t: entry.function(a * np.sin(t), plain) * np.sin(t),
            0.0,
            2.0 * pi,
            limit=400,
            epsabs=0.0,
            epsrel=1e-6,
            points=np.concatenate([np.geomspace(1e-4, 1.0, 9), pi - np.geomspace(1e-4, 1.0, 9), [pi]]),
        )
        return whole / (pi * a)

    np.testing.assert_allclose(found[::3], [exact(a) for a in AMPLITUDES[::3]], rtol=2e-3)


def test_every_term_gets_the_gain_of_its_own_axis_at_every_case():
    gains = gains_with(
        "ladrc", "hybrid", roll__k2=3.0, pitch__k2=4.0, yaw__k2=5.0, roll__k1=0.0, pitch__k1=0.0, yaw__k1=0.0
    )
    cascade = cascade_of("ladrc", "hybrid")
    cases = (Case(0.0), Case(0.2), Case(None))
    found = term_gains(terms_of(cascade), constants_of(cascade, gains, H), 1, cases)
    assert found.shape == (1, 3, 3)
    np.testing.assert_allclose(found[0], [[3.0, 4.0, 5.0]] * 3, rtol=1e-6)
    assert [case.label for case in cases] == ["small signals", "amplitude 0.2", "steepest slope"]
