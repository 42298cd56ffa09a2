"""ADRC with a super-twisting term: what the generalised form adds, and what the observer and the term do for each other."""

from math import sqrt

import numpy as np
import pytest

from plant.laws import hybrid_gsta, hybrid_true_sta, supertwisting
from plant.laws.channel import Channel
from plant.laws.twisting import Twist, super_twisting
from tests.plant.axis import Axis, H, Setpoint, random_inputs, run

GAINS = hybrid_true_sta.Gains(omega_o=15.0, lambda_=2.0, k1=4.0, k2=6.0)


@pytest.mark.parametrize("from_observer", [0.0, 1.0])
def test_the_generalised_term_without_linear_part_is_the_super_twisting_one(from_observer: float) -> None:
    inputs, channel = random_inputs(np.random.default_rng(1), 100), Channel(3.0, from_observer)
    mine, memory = run(hybrid_true_sta.LAW, GAINS, inputs, channel)
    theirs, other = run(hybrid_gsta.LAW, hybrid_gsta.Gains(*GAINS, mu=0.0), inputs, channel)
    np.testing.assert_array_equal(mine, theirs)
    assert memory == other


def test_with_an_observer_that_never_moves_it_is_super_twisting_control() -> None:
    """omega_o -> 0: no correction, so z3 stays 0 and what is left is the law without an observer."""
    inputs, channel = random_inputs(np.random.default_rng(2), 100), Channel(3.0, 0.0)
    mine, _ = run(hybrid_true_sta.LAW, GAINS._replace(omega_o=1e-9), inputs, channel)
    theirs, _ = run(supertwisting.LAW, supertwisting.Gains(2.0, 4.0, 6.0), inputs, channel)
    np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(("mu", "held"), [(0.0, False), (0.5, True)])
def test_a_disturbance_that_grows_with_s_is_held_by_the_linear_part_only(mu: float, held: bool) -> None:
    """S' = w + a S, a = 1: beyond S = (k1/a)^2 = 4 the root is the weaker; with mu k1 > a and mu^2 k2 it is not."""
    constants = hybrid_gsta.LAW.prepare(hybrid_gsta.Gains(15.0, 2.0, k1=2.0, k2=1.5, mu=3.0 * mu), H)
    s, memory = 40.0, Twist(0.0, 0.0, 0.0)
    for _ in range(2000):
        w, memory = super_twisting(memory, s, 0.0, constants)
        s += H * (w + s)
        if s > 1e3:
            break
    assert (abs(s) < 1e-9) == held
    assert (s > 1e3) != held


def test_the_term_needs_to_know_less_of_the_disturbance_with_an_observer() -> None:
    """A disturbance of slope L = 8 y/s3: beyond k2 = 6, so S runs away without an observer; the observer finds all of it but a
    constant 3 L/omega_o, which v takes, and S is held within the L h^2 that sampling leaves.
    """
    axis, hover = Axis(drift=8.0), lambda t: Setpoint(0.0, 0.0, 0.0)
    bare = axis.fly(supertwisting.LAW, supertwisting.Gains(2.0, 4.0, 6.0), 2500, hover)
    both = axis.fly(hybrid_true_sta.LAW, GAINS, 2500, hover)
    assert abs(bare.rate[-1] + 2.0 * bare.value[-1]) > 0.1
    assert abs(both.rate[-1] + 2.0 * both.value[-1]) < 1.5 * 8.0 * H * H
    assert both.memory.twist.v == pytest.approx(-3.0 * 8.0 / 15.0, rel=0.02)


def test_s_is_gone_in_the_time_of_its_root_alone_if_not_sooner() -> None:
    """From S0 = lambda, undisturbed, S falls at least as fast as S' = -k1 S^(1/2), which takes 2 S0^(1/2)/k1."""
    flown = Axis().fly(hybrid_true_sta.LAW, GAINS, 800, lambda t: Setpoint(1.0, 0.0, 0.0))
    s = flown.rate + 2.0 * (flown.value - 1.0)
    t = np.arange(800) * H
    root = np.maximum(sqrt(2.0) - 0.5 * 4.0 * t, 0.0) ** 2
    assert (np.abs(s)[t < 0.5] <= root[t < 0.5] + 0.02).all()
    assert np.abs(s[t > 2.0]).max(axis=0) < 1e-4
    # On S = 0 the error decays as exp(-lambda t).
    late = t > 2.0
    assert np.polyfit(t[late], np.log(np.abs(1.0 - flown.value[late])), 1)[0] == pytest.approx(-2.0, rel=0.02)
