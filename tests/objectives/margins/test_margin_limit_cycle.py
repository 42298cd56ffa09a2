"""Predicted limit cycles against the closed form for super-twisting with a lag and against flights of the sampled loop."""

from math import pi, sqrt

import numpy as np
import pytest

from objectives.margins.limit_cycle import limit_cycles
from objectives.margins.period import PeriodMap
from objectives.margins.trim import Trim, setting_of, smooth_dynamics
from plant.loop import Timing
from plant.quadrotor.closed_loop import hover_body
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.records import flatten, paths
from tests.objectives.margins.designs import (
    HUMMINGBIRD,
    TIMING,
    cascade_of,
    default_gains,
    gains_with,
    ideal_vehicle,
    model_of,
)
from tests.objectives.margins.stepping import Stepper

LAG, K1, K2 = 0.05, 1.5, 1.1
YAW = 5
UNAWARE = ControlOptions(lag_aware=False)
DELAYED = ControlOptions(delay=True)


def yaw_cycles(pair, gains, options, vehicle=HUMMINGBIRD, timing=TIMING):
    found = limit_cycles(model_of(*pair, options, vehicle=vehicle, timing=timing), gains)
    return [cycle for cycle in found if cycle.channels == ("yaw",)]


def twisting(pair):
    """Gains whose surface is all but the rate, so that S' = u + d with a lag."""
    return gains_with(*pair, yaw__lambda=1e-3, yaw__k1=K1, yaw__k2=K2)[0]


@pytest.mark.parametrize("law", ["supertwisting", "supertwisting_euler"])
def test_super_twisting_with_a_lag_swings_as_harmonic_balance_says_in_closed_form(law):
    """The balance of N = 2/sqrt(pi) G(5/4)/G(7/4) k1 A^(-1/2) - 4j k2/(pi A w) with 1/s/(mu s + 1), in the limit of fast sampling."""
    pair = ("pid", law)
    found = []
    for h in (2e-3, 1e-3, 0.5e-3):
        (cycle,) = yaw_cycles(pair, twisting(pair), UNAWARE, ideal_vehicle(LAG), Timing(h, h))
        assert cycle.stable
        found.append([cycle.frequency, cycle.amplitudes["yaw", "root term"]])
    coarse, middle, fine = np.array(found)
    limit = (8.0 * fine - 6.0 * middle + coarse) / 3.0
    # -N G = 1: imaginary part n1 w = n2/w + ..., with s(mu s + 1) = -mu w^2 + j w.
    n1 = 1.112836 * K1
    amplitude = lambda w: (n1 / (LAG * w * w)) ** 2  # noqa: E731
    w = sqrt(n1**2 * pi / (4.0 * K2)) / LAG
    assert w == pytest.approx(0.986 * K1 / (LAG * sqrt(K2)), rel=1e-3)
    np.testing.assert_allclose(limit, [w, amplitude(w)], rtol=2e-3)


def flown(pair, gains, options, vehicle, timing, rate, slope):
    """S = rate + slope yaw in the second half of 2.4 s of flight that start turning at a rate [rad/s]."""
    cascade, knowledge = cascade_of(*pair), nominal(vehicle, options, timing.control_period)
    stepper = Stepper(cascade, knowledge, timing, smooth_dynamics(vehicle), Trim())
    setting = setting_of(Trim(), knowledge, vehicle)
    (rest,) = PeriodMap(cascade, timing).at_rest(
        np.array(flatten(hover_body(knowledge))), gains[None], setting.nominal, setting.reference, setting.dynamics
    )
    state, turning = rest[0].tolist(), paths(stepper.state).index("body.rate.z")
    state[turning] = rate
    signal = []
    for _ in range(round(2.4 / timing.control_period)):
        before = state[turning]
        after, _, seen = stepper.step(state, gains.tolist())
        signal.append(before + slope * seen[YAW])
        state = after.tolist()
    last = np.array(signal[len(signal) // 2 :])
    return last - last.mean(axis=0)


def oscillation(signal, h):
    """Frequency from upward zero crossings, and amplitude of the first harmonic over whole periods."""
    up = np.nonzero((signal[:-1] < 0.0) & (signal[1:] >= 0.0))[0]
    at = up + signal[up] / (signal[up] - signal[up + 1])
    w = 2.0 * pi * (len(at) - 1) / ((at[-1] - at[0]) * h)
    whole = np.arange(up[0], up[-1])
    return w, abs(2.0 * np.mean(signal[whole] * np.exp(-1j * w * h * whole), axis=0))


@pytest.mark.slow
def test_super_twisting_flies_the_cycle_that_is_predicted():
    pair, timing = ("pid", "supertwisting"), Timing(2e-3, 1e-3)
    gains = twisting(pair)
    (cycle,) = yaw_cycles(pair, gains, UNAWARE, ideal_vehicle(LAG), timing)
    w, amplitude = oscillation(
        flown(pair, gains, UNAWARE, ideal_vehicle(LAG), timing, 0.002, 1e-3), timing.control_period
    )
    # What the describing function leaves out: higher harmonics of the sign.
    assert w == pytest.approx(cycle.frequency, rel=0.01)
    assert amplitude == pytest.approx(cycle.amplitudes["yaw", "switching term"], rel=0.02)


@pytest.mark.slow
def test_a_hybrid_law_with_too_large_a_gain_has_an_edge_and_a_cycle_and_flies_both():
    pair, slope = ("pid", "hybrid"), 5.0
    gains = gains_with(*pair, yaw__k1=40.0, yaw__delta=0.01, yaw__k2=5.0, yaw__lambda=slope)[0]
    # Rotors without inertia: the lead of real ones takes this cycle away.
    light = HUMMINGBIRD._replace(rotor_inertia=0.0)
    edge, cycle = yaw_cycles(pair, gains, DELAYED, light)
    assert (edge.stable, cycle.stable) == (False, True)
    low, high = (each.amplitudes["yaw", "sliding term"] for each in (edge, cycle))

    def from_rate(rate):
        return flown(pair, gains, DELAYED, light, TIMING, rate, slope)

    w, amplitude = oscillation(from_rate(3.0 * high), TIMING.control_period)
    assert w == pytest.approx(cycle.frequency, rel=0.02)
    assert amplitude == pytest.approx(high, rel=0.05)
    assert np.abs(from_rate(0.5 * low)[-100:]).max(axis=0) < 0.2 * low
    assert np.abs(from_rate(3.0 * low)[-100:]).max(axis=0) > 0.8 * high


def test_sound_designs_have_no_limit_cycle():
    assert limit_cycles(model_of("ladrc", "hybrid"), default_gains("ladrc", "hybrid")) == ()
    assert limit_cycles(model_of("pid", "ladrc"), default_gains("pid", "ladrc")) == ()
