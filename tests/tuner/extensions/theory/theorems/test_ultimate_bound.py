"""The ultimate bound of the hybrid law: its equation solved, its table, and the law itself held against it."""

from math import inf

import numpy as np
import pytest
from scipy.optimize import brentq

from plant.law_registry import LAWS
from plant.laws.hybrid import Gains
from tests.tuner.extensions.theory.theorems.channel import fly
from tuner.extensions.theory.theorems import THEOREMS, Setting
from tuner.extensions.theory.theorems.observer_error import disturbance_bound
from tuner.extensions.theory.theorems.ultimate_bound import ultimate_error, ultimate_surface


@pytest.mark.parametrize(
    ("delta", "table"), [(0.001, 0.0024), (0.01, 0.0062), (0.05, 0.0173), (0.1, 0.0266), (0.5, 0.0656)]
)
def test_the_table(delta, table):
    # T14: residual 1, k1 = 20, k2 = 5; four digits behind the point.
    assert ultimate_surface(*np.array([20.0, 5.0, delta, 1.0])) == pytest.approx(table, abs=5e-5)


def test_alone_each_term_has_its_closed_form():
    # Linear only: E/k2. Without saturation (delta below S*) and k2 = 0: (E/k1)^2. Inside delta with k2 = 0: (E delta/k1)^(2/3).
    k1, k2 = np.array([0.0, 20.0, 20.0]), np.array([5.0, 0.0, 0.0])
    found = ultimate_surface(k1, k2, np.array([0.1, 1e-4, 0.5]), np.ones(3))
    np.testing.assert_allclose(found, [0.2, 1.0 / 400.0, (0.5 / 20.0) ** (2.0 / 3.0)], rtol=1e-14)


def test_no_gain_no_bound_and_no_residual_no_error():
    nothing, some = np.zeros(2), np.array([20.0, 0.0])
    assert ultimate_surface(nothing, nothing, np.full(2, 0.1), np.array([1.0, 0.0])).tolist() == [inf, 0.0]
    assert ultimate_surface(some, some, np.full(2, 0.1), nothing).tolist() == [0.0, 0.0]


def left_side(s, k1, k2, delta):
    return k1 * np.sqrt(s) * np.minimum(s / delta, 1.0) + k2 * s


def test_it_solves_its_equation_over_all_magnitudes():
    axis = 10.0 ** np.arange(-4, 5, 1.6)
    k1, k2, delta, residual = (part.ravel() for part in np.meshgrid(axis, axis, axis, axis))
    found = ultimate_surface(k1, k2, delta, residual)
    np.testing.assert_allclose(left_side(found, k1, k2, delta), residual, rtol=1e-13)
    draw = np.random.default_rng(2)
    for i in draw.choice(len(found), 40, replace=False):
        rest = (k1[i], k2[i], delta[i])
        root = brentq(lambda s, rest=rest, i=i: left_side(s, *rest) - residual[i], 0.0, 2.0 * residual[i] / k2[i])
        assert found[i] == pytest.approx(root, rel=1e-7)


GAINS, PERIOD = Gains(omega_o=20.0, lambda_=4.0, k1=8.0, k2=5.0, delta=0.2), 0.001


def bound(rate):
    return float(ultimate_error(GAINS, Setting(PERIOD, rate)))


@pytest.mark.parametrize("rate", [2.0, 60.0])
def test_the_flown_law_under_a_ramp_reaches_it(rate):
    # From both branches: S* is below delta at rate 2, above at 60. Over a period the observer falls behind from (3 c - 1) h/2 to
    # (3 c + 1) h/2 and the loop feels the mean, less than the bound by a share of wo h/6 = 0.3 %.
    y, _ = fly(LAWS["hybrid"], GAINS, PERIOD, [rate] * 8000)
    assert bound(rate) * (1.0 - 0.02) < abs(y[-1]) < bound(rate)
    residual = disturbance_bound(np.array(20.0), Setting(PERIOD, rate))
    surface = ultimate_surface(*map(np.array, (GAINS.k1, GAINS.k2, GAINS.delta, residual)))
    assert (surface < GAINS.delta) == (rate == 2.0)


@pytest.mark.parametrize("hold", [30, 300, 1500])
def test_the_flown_law_stays_below_it_under_any_disturbance_of_that_rate(hold):
    slopes = np.repeat(np.random.default_rng(hold).choice([-40.0, 40.0], 12000 // hold), hold)
    y, _ = fly(LAWS["hybrid"], GAINS, PERIOD, slopes.tolist())
    assert np.abs(y).max(axis=0) < bound(40.0)


def test_which_laws_it_speaks_of():
    theorem = THEOREMS["ultimate_error"]
    assert theorem.laws == ("hybrid",) and theorem.sense == "max" and theorem.unit_in("attitude") == "rad"
    assert theorem.speaks_of("hybrid", rate_from_observer=False)
    assert not theorem.speaks_of("hybrid", rate_from_observer=True)
    assert not theorem.speaks_of("hybrid_literal", rate_from_observer=False)
