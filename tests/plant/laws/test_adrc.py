"""Nonlinear ADRC: fal, the nonlinear observer, and the linear law that it is while errors are small."""

import numpy as np
import pytest

from plant.laws import ladrc
from plant.laws.adrc import LAW, Gains, error_term, rate_term
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.fal import fal_1_2, fal_1_4, fal_3_2, fal_3_4
from plant.laws.nonlinear_observer import disturbance_correction, observe_nonlinearly, rate_correction
from plant.laws.observer import Observer, observe
from tests.plant.axis import Axis, H, Input, run
from tests.plant.harness import Array

GAINS = Gains(omega_c=4.0, zeta=0.8, omega_o=15.0, delta_1=0.2, delta_2=0.9, delta_0=0.05, r_0=40.0)
CONSTANTS = LAW.prepare(GAINS, H)
FALS = {0.25: fal_1_4, 0.5: fal_1_2, 0.75: fal_3_4, 1.5: fal_3_2}


def fal(e: float, exponent: float, delta: float) -> float:
    """Han's definition."""
    return e / delta ** (1.0 - exponent) if abs(e) <= delta else abs(e) ** exponent * np.sign(e)


@pytest.mark.parametrize("exponent", FALS)
@pytest.mark.parametrize("delta", [1e-3, 0.2, 30.0])
def test_scaled_fal_is_hans_fal_with_unit_slope(exponent: float, delta: float) -> None:
    for e in (delta * np.geomspace(1e-4, 1e6, 60)).tolist():
        assert FALS[exponent](e, delta) == pytest.approx(delta ** (1.0 - exponent) * fal(e, exponent, delta), rel=1e-14)
        assert FALS[exponent](-e, delta) == -FALS[exponent](e, delta)
    for e in (-delta, -0.3 * delta, 0.0, 1e-30 * delta, delta):
        assert FALS[exponent](e, delta) == e  # linear to the last bit, up to where it changes over


def test_each_term_has_its_own_exponent_and_its_linear_gain() -> None:
    """The source uses one pair of letters for two pairs of exponents: 3/4 and 3/2 in the feedback, 1/2 and 1/4 in the observer."""
    terms = [
        (error_term, 0.75, 0.2, 16.0),
        (rate_term, 1.5, 0.9, 6.4),
        (rate_correction, 0.5, 0.05, CONSTANTS.observer.gains.l2),
        (disturbance_correction, 0.25, 0.05, CONSTANTS.observer.gains.l3),
    ]
    for term, exponent, delta, gain in terms:
        assert term(0.5 * delta, CONSTANTS) == pytest.approx(0.5 * gain * delta, rel=1e-14)
        # Between 16 delta and 256 delta it grows by 16^exponent.
        assert term(256.0 * delta, CONSTANTS) / term(16.0 * delta, CONSTANTS) == pytest.approx(
            16.0**exponent, rel=1e-12
        )


@pytest.mark.parametrize("from_observer", [0.0, 1.0])
def test_inside_the_linear_zones_it_is_ladrc(from_observer: float) -> None:
    """Along a reference that the differentiator passes, with errors of a hundredth of the zones: the same commands, bit by bit."""
    rng, path = np.random.default_rng(1), [Setpoint(0.3, 0.1, 0.5)]
    for acceleration in rng.uniform(-1.0, 1.0, 300).tolist():
        y, v, a = path[-1]
        path.append(Setpoint(y + H * v + 0.5 * H * H * a, v + H * a, acceleration))
    inputs = [
        Input(
            p,
            Measured(p.value + 5e-4 * rng.standard_normal(), p.rate + 5e-3 * rng.standard_normal()),
            Applied(p.acceleration / 3.0, 0.0),
        )
        for p in path
    ]
    start = LAW.start(CONSTANTS, Measured(0.3, 0.1), 0.0)
    mine, _ = run(LAW, GAINS, inputs, Channel(3.0, from_observer), memory=start)
    theirs, _ = run(ladrc.LAW, ladrc.Gains(4.0, 0.8, 15.0), inputs, Channel(3.0, from_observer), memory=start.observer)
    np.testing.assert_array_equal(mine, theirs)
    assert np.abs(mine).max(axis=0) > 0.1


def test_far_outside_an_error_counts_less_and_its_rate_more_than_in_ladrc() -> None:
    """One period from rest at e1 = 16 delta1, e2 = 16 delta2: 16^(-1/4) = 1/2 of kp e1 and 16^(1/2) = 4 times kd e2."""
    memory = LAW.start(CONSTANTS, Measured(0.0, 0.0), 0.0)
    ahead = memory._replace(profile=memory.profile._replace(v1=16.0 * 0.2))
    moving = memory._replace(profile=memory.profile._replace(v2=16.0 * 0.9))
    at_rest, channel = (Measured(0.0, 0.0), Applied(0.0, 0.0), H), Channel(1.0, 0.0)
    u, _ = LAW.step(ahead, CONSTANTS, channel, Setpoint(3.2, 0.0, 0.0), *at_rest)
    assert u == pytest.approx(0.5 * 16.0 * 3.2, rel=1e-12)
    u, _ = LAW.step(moving, CONSTANTS, channel, Setpoint(0.0, 14.4, 0.0), *at_rest)
    assert u == pytest.approx(4.0 * 6.4 * 14.4, rel=1e-12)


def test_the_observer_is_the_linear_one_for_small_innovations_and_slower_for_large_ones() -> None:
    # y jumps by a: z3 answers with l3 a inside the zone and with l3 a (a/delta)^(-3/4) outside.
    rng, z, twin = np.random.default_rng(2), Observer(0.1, 0.2, 0.3), Observer(0.1, 0.2, 0.3)
    for known in rng.uniform(-1.0, 1.0, 200).tolist():
        y = z.z1 + H * z.z2 + 0.04 * float(rng.uniform(-1.0, 1.0))
        z, twin = observe_nonlinearly(z, CONSTANTS, y, known, H), observe(twin, CONSTANTS.observer.gains, y, known, H)
        assert z == twin
    still = Observer(0.0, 0.0, 0.0)
    jumped = observe_nonlinearly(still, CONSTANTS, 16.0 * 0.05, 0.0, H)
    linear = observe(still, CONSTANTS.observer.gains, 16.0 * 0.05, 0.0, H)
    assert jumped.z1 == linear.z1
    np.testing.assert_allclose([jumped.z2 / linear.z2, jumped.z3 / linear.z3], [0.25, 0.125], rtol=1e-12)


def error_matrix(omega_o_h: float, beyond: float) -> Array:
    """One period on the estimation error (z1, h z2, h^2 z3) with the gains that act at an innovation of `beyond` delta."""
    constants = LAW.prepare(GAINS._replace(omega_o=omega_o_h / H, delta_0=1.0), H)
    l2, l3 = rate_correction(beyond, constants) / beyond, disturbance_correction(beyond, constants) / beyond
    gain = np.array([constants.observer.gains.l1, l2 * H, l3 * H * H])
    predict = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    return predict - np.outer(gain, predict[0])


@pytest.mark.parametrize("omega_o_h", [0.01, 0.1, 0.3, 1.0, 2.0, 5.0, 20.0])
def test_the_observer_is_stable_at_every_amplitude(omega_o_h: float) -> None:
    for beyond in np.geomspace(1.0, 1e6, 25).tolist():
        poles = np.linalg.eigvals(error_matrix(omega_o_h, beyond))
        assert np.abs(poles).max(axis=0) < 1.0 - 1e-6


@pytest.mark.parametrize("jump", [1.0, 1e2, 1e4])
def test_the_observer_finds_its_way_back_from_any_innovation(jump: float) -> None:
    """A jump of y by `jump` deltas, flown out at constant y: estimates end at y, 0 and 0."""
    z, y = Observer(0.0, 0.0, 0.0), jump * 0.05
    largest = 0.0
    for _ in range(60000):
        z = observe_nonlinearly(z, CONSTANTS, y, 0.0, H)
        largest = max(largest, abs(z.z1 - y))
    np.testing.assert_allclose(z, [y, 0.0, 0.0], rtol=0.0, atol=1e-9 * y)
    assert largest < y  # no growth on the way


def test_a_step_is_flown_along_the_profile_of_the_differentiator() -> None:
    """Undisturbed, the response lags the profile by the feedback alone: it rises later than 2 sqrt(R/r0) and settles."""
    slow, fast = (
        Axis().fly(LAW, GAINS._replace(r_0=r_0), 2500, lambda t: Setpoint(1.0, 0.0, 0.0)) for r_0 in (0.5, 1000.0)
    )
    for flown, r_0 in ((slow, 0.5), (fast, 1000.0)):
        assert flown.value[-1] == pytest.approx(1.0, abs=1e-6)
        assert np.abs(flown.value - 1.0)[round(0.8 * 2.0 * r_0**-0.5 / H)] > 0.01
    assert CONSTANTS.h_0 == pytest.approx(5.0 * H, rel=1e-12)
    # Bounded acceleration of the profile: what is commanded at first is small where r0 is.
    assert np.abs(slow.command).max(axis=0) < 1.5
    assert np.abs(fast.command).max(axis=0) > 10.0
