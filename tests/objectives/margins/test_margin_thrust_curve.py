"""Margins of rotors with a thrust curve: the loop times the slope at hover over that of the curve that the controller inverts."""

import numpy as np
import pytest

from objectives.margins.margins import MarginModel
from objectives.margins.trim import Trim
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.nominal import ControlOptions, nominal
from tests.objectives.margins.designs import HUMMINGBIRD, TIMING, H, cascade_of, random_gains
from tests.objectives.margins.test_margin_linearise import TRIMS, differences, linearised

LEVEL = Trim(hold=False)
ASSUMED = 0.3


def model(linear: float, assumed: float) -> MarginModel:
    known = nominal(HUMMINGBIRD._replace(thrust_linear=assumed), ControlOptions(), H)
    vehicle = HUMMINGBIRD._replace(thrust_linear=linear)
    return MarginModel(cascade_of("pid", "ladrc"), known, TIMING, vehicle, LEVEL)


@pytest.mark.parametrize("channel", ["z", "roll", "yaw"])
@pytest.mark.parametrize("linear", [-0.2, 0.0, 0.3, 0.7])
def test_the_loop_has_the_quotient_of_the_slopes_at_hover(channel, linear):
    """At the command that carries the weight; one where the controller inverts the curve that flies."""
    (row,) = random_gains("pid", "ladrc", 1, 5, 0.1)
    w = np.geomspace(0.5, 600.0, 40)
    rotors = actuation(HUMMINGBIRD._replace(thrust_linear=linear))
    u = rotors.hover_command
    quotient = rotors.hover_slope / (rotors.thrust_max * (2.0 * (1.0 - ASSUMED) * u + ASSUMED))
    assert (quotient == pytest.approx(1.0, rel=1e-12)) is (linear == ASSUMED)
    plain = model(0.0, 0.0).loop(row, channel, frequency=w).loop
    found = model(linear, ASSUMED).loop(row, channel, frequency=w).loop
    assert found == pytest.approx(quotient * plain, rel=1e-7)


@pytest.mark.parametrize("name", ["hover", "turned in wind"])
def test_derivatives_are_those_of_plain_python(name):
    """In wind each rotor has a slope of its own."""
    pair, gains = ("pid", "ladrc"), random_gains("pid", "ladrc", 1, 5, 0.1)
    vehicle, assumed = (HUMMINGBIRD._replace(thrust_linear=a) for a in (0.6, ASSUMED))
    _, stepper, point, closed = linearised(pair, TRIMS[name], ControlOptions(), gains, vehicle, assumed)
    assert point.steady.all()
    found = differences(lambda v: stepper.injected(point.state[0], gains[0], v), np.zeros(6), np.full(6, 1e-5))
    rows = np.r_[closed.command, closed.output]
    exact = np.concatenate([closed.b[0], closed.d[0][rows]])[:, closed.injected]
    scale = np.maximum(np.abs(exact).max(axis=1, keepdims=True), 1.0)
    np.testing.assert_allclose(found / scale, exact / scale, rtol=0.0, atol=1e-7)
