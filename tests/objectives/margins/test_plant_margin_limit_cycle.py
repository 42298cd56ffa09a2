"""Limit cycles of plants of one's own by harmonic balance: the closed form of super-twisting behind a lag, and a flight."""

from math import pi, sqrt

import numpy as np
import pytest

from objectives.margins.limit_cycle import limit_cycles
from objectives.margins.plant_margins import PlantMargins
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.plan import Actuator, Channel
from plant.model.scenario import PlantScenario
from plant.model.signals import signal_from
from plant.quadrotor.scenarios import SEARCH
from tests.objectives.margins.test_margin_limit_cycle import oscillation
from tests.plant.model.plants import CASCADE_GAINS, cascade, pid, stepped, system_of

LAG, K1, K2, SLOPE = 0.05, 1.5, 1.1, 1e-3
GAINS = np.array([SLOPE, K1, K2])


def free_body(timing, b0=1.0, every=1, outer=()):
    """A body without friction whose torque lags, under super-twisting on its speed; b0: its acceleration for one N m."""
    channel = Channel("angle", LAWS["supertwisting"], "angle", "torque", b0=b0, rate_output="speed", every=every)
    system = system_of("pendulum", [channel, *outer], [Actuator("torque", lag=LAG)], timing)
    free = system.plant.Parameters(inertia=1.0 / b0, friction=0.0, weight=0.0, start=0.0)
    object.__setattr__(system, "parameters", free)
    return system


def cycles(system, gains):
    return limit_cycles(PlantMargins(system, 0.9 * gains, 1.1 * gains), gains)


@pytest.mark.parametrize("b0", [1.0, -40.0])
def test_super_twisting_behind_a_lag_swings_as_in_closed_form(b0):
    """N(A) = 1.112836 k1 A^(-1/2) - 4j k2/(pi A w) against s (lag s + 1), whatever the unit of the command: see Levant's law."""
    found = []
    for h in (2e-3, 1e-3, 0.5e-3):
        (cycle,) = cycles(free_body(Timing(h, h), b0), GAINS)
        assert cycle.stable and cycle.channels == ("angle",)
        found.append([cycle.frequency, cycle.amplitudes["angle", "root term"]])
    coarse, middle, fine = np.array(found)
    root = 1.112836 * K1
    w = sqrt(root**2 * pi / (4.0 * K2)) / LAG
    np.testing.assert_allclose((8.0 * fine - 6.0 * middle + coarse) / 3.0, [w, (root / (LAG * w * w)) ** 2], rtol=2e-3)


def test_a_plant_flies_the_cycle_that_is_predicted():
    timing = Timing(1e-3, 1e-3)
    system = free_body(timing)
    (cycle,) = cycles(system, GAINS)
    kick = signal_from({"kind": "step", "size": 0.1, "until": 0.02})
    drawn = system.sample(PlantScenario("kick", 4.0, {}, {"push": kick}), 1, SEARCH, range(1))
    body, _ = stepped(system, GAINS, drawn)
    signal = (body[:, 1] + SLOPE * body[:, 0])[len(body) // 2 :]
    w, amplitude = oscillation(signal - signal.mean(axis=0), timing.control_period)
    # What the describing function leaves out: higher harmonics of the sign.
    assert w == pytest.approx(cycle.frequency, rel=0.015)
    assert amplitude == pytest.approx(cycle.amplitudes["angle", "switching term"], rel=0.04)


def test_linear_laws_have_none():
    linear = system_of("pendulum", [pid("angle", "angle", "torque", b0=50.0)], [], Timing(0.002, 0.001))
    assert cycles(linear, np.array([40.0, 10.0, 12.0, 0.01])) == () == cycles(cascade(), CASCADE_GAINS)


def test_a_law_at_every_fourth_period_swings_as_at_a_period_four_times_as_long():
    (slow,), (plain,) = (cycles(free_body(Timing(h, h), every=n), GAINS) for h, n in ((1e-3, 4), (4e-3, 1)))
    assert slow.frequency == pytest.approx(plain.frequency, rel=1e-6) and slow.stable
    assert slow.amplitudes == pytest.approx(plain.amplitudes, rel=1e-5)


def test_a_cycle_faster_than_the_common_period_can_show_has_its_own_frequency():
    """28 rad/s under a loop that steps every 0.16 s, whose gains are too small to change it."""
    timing = Timing(5e-3, 5e-3)
    under = free_body(timing, outer=[pid("slow", "angle", "angle", every=32)])
    (alone,), (inside, *_) = cycles(free_body(timing), GAINS), cycles(under, np.array([1e-6, 0.0, 0.0, 0.01, *GAINS]))
    assert alone.frequency > np.pi / 0.16
    assert inside.channels == ("slow", "angle") and inside.frequency == pytest.approx(alone.frequency, rel=1e-4)
