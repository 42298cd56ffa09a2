"""Margins on a worn battery, against the closed form: attitude loops lose the square of the voltage, or nothing."""

import numpy as np
import pytest

from objectives.margins.trim import Trim
from plant.quadrotor.nominal import ControlOptions
from tests.objectives.margins.designs import HUMMINGBIRD, gains_with, model_of

WEAK = HUMMINGBIRD._replace(
    battery_full=12.6,
    battery_empty=10.5,
    battery_resistance=0.06,
    battery_capacity=7200.0,
    battery_used=5400.0,
    hover_power=90.0,
)
W = np.geomspace(0.5, 600.0, 40)


@pytest.mark.parametrize("channel", ["roll", "yaw"])
@pytest.mark.parametrize("compensation", [0.0, 1.0])
def test_an_attitude_loop_has_the_square_of_the_voltage(channel, compensation):
    """Rotors that speed up as others slow down leave the voltage alone, so what it takes from the loop is a factor."""
    worn, full = (max(np.roots([1.0, -rest, 0.06 * 90.0])) for rest in (12.6 - 0.75 * 2.1, 12.6))
    (row,) = gains_with("pid", "pid")
    options = ControlOptions(battery_compensation=compensation)
    plain, weak = (
        model_of("pid", "pid", options, Trim(hold=False), vehicle=vehicle) for vehicle in (HUMMINGBIRD, WEAK)
    )
    factor = (worn / full) ** 2 if compensation == 0.0 else 1.0
    found = weak.loop(row, channel, frequency=W).loop
    assert found == pytest.approx(factor * plain.loop(row, channel, frequency=W).loop, rel=1e-6, abs=1e-9)


def test_the_height_feels_the_sag_beyond_that():
    """A thrust that grows draws the voltage down as it does, so height loses more than the square of the voltage."""
    worn, full = (max(np.roots([1.0, -rest, 0.06 * 90.0])) for rest in (12.6 - 0.75 * 2.1, 12.6))
    (row,) = gains_with("pid", "pid")
    plain, weak = (model_of("pid", "pid", trim=Trim(), vehicle=vehicle) for vehicle in (HUMMINGBIRD, WEAK))
    ratio = np.abs(weak.loop(row, "z", frequency=W).loop / plain.loop(row, "z", frequency=W).loop)
    # Far below the rotors' pole: V falls by a share of 3 R P/(V (2 V - rest)) of a rise in speed, dV/V = -share dw/w.
    share = 3.0 * 0.06 * 90.0 / (worn * (2.0 * worn - (12.6 - 0.75 * 2.1)))
    assert ratio[0] == pytest.approx((worn / full) ** 2 / (1.0 + share), rel=2e-3)
