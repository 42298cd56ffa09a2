"""Errata of the paper's theory: each test shows what is wrong with the printed statement and that the one used is right.

Wu et al., Appl. Sci. 2025, 15(9), 5124. E8: the Lyapunov proof. E17: the gain conditions (22) and (31). Swapping a printed form
for the one used, or the other way round, fails here.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plant.law_registry import LAWS
from plant.laws import hybrid, supertwisting
from plant.laws.channel import Measured
from tests.tuner.extensions.theory.theorems.channel import fly
from tests.tuner.extensions.theory.theorems.printed import printed_31_bound, printed_least_gains
from tuner.extensions.theory.theorems import THEOREMS, Setting
from tuner.extensions.theory.theorems.ultimate_bound import ultimate_surface

RESIDUAL, DELTA = 1.0, 0.1


@pytest.mark.parametrize("gains", [(20.0, 5.0), (2e3, 5e2), (2e7, 5e7)])
def test_e08_no_finite_gains_satisfy_the_printed_conditions_near_the_surface(gains):
    near = 10.0 ** -np.arange(0.0, 13.0)
    asked = printed_least_gains(near, RESIDUAL, DELTA)
    assert asked.k1[-1] > gains[0] and asked.k2[-1] > gains[1]
    # Towards S = 0 they grow as |S|^(-3/2) and 1/|S|, so the maximum over S that the text asks for does not exist.
    inside = near <= DELTA
    for needed, power in ((asked.k1, -1.5), (asked.k2, -1.0)):
        slopes = np.diff(np.log10(needed[inside])) / np.diff(np.log10(near[inside]))
        np.testing.assert_allclose(slopes, power, rtol=1e-9)


def surface_rate(_, s, constants, residual):
    """S' = eps - k1 |S|^(1/2) sat(S/delta) - k2 S, with the sliding term of the law that flies."""
    return [residual - hybrid.sliding_term(float(s[0]), constants)]


@pytest.mark.parametrize("delta", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("start", [0.0, 0.4, -0.4])
def test_e08_with_the_residual_at_its_bound_the_surface_is_not_reached_but_the_ultimate_bound_is(delta, start):
    gains = hybrid.Gains(10.0, 5.0, 20.0, 5.0, delta)
    flow = solve_ivp(
        surface_rate,
        (0.0, 8.0),
        [start],
        args=(hybrid.prepare(gains, 0.004), RESIDUAL),
        method="LSODA",
        rtol=1e-9,
        atol=1e-12,
    )
    reached = flow.y[0, -1]
    bound = float(ultimate_surface(*np.array([gains.k1, gains.k2, delta, RESIDUAL])))
    assert reached == pytest.approx(bound, rel=1e-5)
    assert bound > 0.002
    # The printed claim is asymptotic stability, S -> 0; the gains break its conditions exactly inside that bound: V' > 0 there.
    within, beyond = (hybrid.sliding_term(factor * bound, hybrid.prepare(gains, 0.004)) for factor in (0.99, 1.01))
    assert within < RESIDUAL < beyond


def test_e08_the_proof_needs_either_gain_where_the_text_asks_for_both():
    # At one |S| = s inside delta, k1 alone at what is printed, or k2 alone, already makes the sliding term equal to the residual.
    for s in (0.003, 0.02, 0.09):
        asked = printed_least_gains(np.array(s), RESIDUAL, DELTA)
        for k1, k2 in ((float(asked.k1), 0.0), (0.0, float(asked.k2))):
            constants = hybrid.prepare(hybrid.Gains(10.0, 5.0, k1, k2, DELTA), 0.004)
            assert hybrid.sliding_term(s, constants) == pytest.approx(RESIDUAL, rel=1e-12)


def test_e08_outside_delta_a_factor_of_s_too_many_is_printed():
    # There V' <= 0 asks for k1 > eps |S|^(-1/2) or k2 > eps/|S|, which fall with |S|; the printed ones do not.
    s = np.array([0.2, 2.0, 20.0])
    asked = printed_least_gains(s, RESIDUAL, DELTA)
    np.testing.assert_allclose(asked.k1 / (RESIDUAL / np.sqrt(s)), s, rtol=1e-12)
    np.testing.assert_allclose(asked.k2 / (RESIDUAL / s), s, rtol=1e-12)


def away(k1, k2, rate, seconds=60.0, h=0.002):
    """Return by how much the worst disturbance of that rate enlarges S' of the flown super-twisting law from 0.001."""
    last = [0.0]

    def push(y, v, d):
        s, last[0] = v + y - last[0], v + y
        return rate if s > 0.0 else -rate

    gains = supertwisting.Gains(lambda_=1.0, k1=k1, k2=k2)
    y, v = fly(LAWS["supertwisting"], gains, h, [push] * round(seconds / h), Measured(0.0, 0.001))
    return float(np.abs(v + y).max(axis=0)) / 0.001


def borne(k1, k2):
    gains = supertwisting.Gains(1.0, k1, k2)
    return {
        name: float(THEOREMS[name].values["supertwisting"](gains, Setting(0.004, 0.0)))
        for name in THEOREMS
        if name.startswith("sta_")
    }


def test_e17_printed_31_accepts_gains_that_the_disturbance_carries_away():
    # eps = 0.01, alpha = 1: k1 > 0.02 and k2 > 0.01 is all that (31) asks for.
    k1, k2, rate = 0.03, 0.011, 0.01
    assert printed_31_bound(np.array(k1), np.array(k2)) > rate
    assert max(borne(k1, k2).values()) < rate
    assert away(k1, k2, rate) > 50.0
    # Gains of the same k2 that Seeber and Horn accept hold against the same disturbance.
    assert borne(0.15, k2)["sta_seeber_horn"] > rate
    assert away(0.15, k2, rate) < 1.5


def test_e17_printed_31_compares_quantities_of_different_units():
    # In other units of S, or with time c times faster, c k1 and c^2 k2 do what k1 and k2 did, to c^2 the rate.
    k1, k2 = np.array([0.5, 1.5, 2.0, 6.0]), np.array([0.3, 1.1, 2.0, 8.0])
    for name in borne(1.0, 1.0):
        rate = THEOREMS[name].values["supertwisting"]
        gains = LAWS["supertwisting"].Gains
        one, other = (rate(gains(1.0, c * k1, c * c * k2), Setting(0.004, 0.0)) for c in (1.0, 4.0))
        np.testing.assert_allclose(other, 16.0 * one, rtol=1e-9, atol=1e-12)
    assert not np.allclose(printed_31_bound(4.0 * k1, 16.0 * k2), 16.0 * printed_31_bound(k1, k2), rtol=0.5)


def test_e17_22_is_sufficient_and_contradicts_31():
    # (22) and (31) are printed as conditions on the same gains: at k1 = 1.5, k2 = 1.1 one bears 0.025, the other 0.75.
    assert borne(1.5, 1.1)["sta_paper22"] == pytest.approx(0.025)
    assert printed_31_bound(np.array(1.5), np.array(1.1)) == 0.75
    for k1, k2 in ((1.5, 1.1), (3.0, 1.0), (6.0, 8.0)):
        found = borne(k1, k2)
        assert found["sta_paper22"] <= found["sta_seeber_horn"] <= found["sta_worst_case"] * (1.0 + 1e-12)


def test_e17_neither_speaks_of_the_hybrid_law():
    # E5: without the integral of the sign there is nothing that (22) or (31) could be conditions for.
    for name in THEOREMS:
        if name.startswith("sta_"):
            assert not THEOREMS[name].speaks_of("hybrid", rate_from_observer=False)
