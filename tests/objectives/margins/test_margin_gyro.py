"""Margins of loops whose gyro hears a mode of the frame and has a low-pass, against python-control's sampled transfer functions."""

from dataclasses import replace

import control
import numpy as np
import pytest

from objectives.margins.trim import Trim
from plant.loop import Timing
from tests.objectives.margins.designs import HUMMINGBIRD, OPTIONS, gains_with, model_of

H = 0.001
TIMING = Timing(H, H)
FREQUENCY, DAMPING, GAIN, CUTOFF = 60.0, 0.05, 0.2, 180.0
W = np.geomspace(1.0, 2800.0, 60)
FLEXIBLE = HUMMINGBIRD._replace(mode_frequency=FREQUENCY, mode_damping=DAMPING, mode_gain=GAIN, gyro_cutoff=CUTOFF)


def model(vehicle, options=OPTIONS["delayed"]):
    return model_of("pid", "pid", options, trim=Trim(hold=False), vehicle=vehicle, timing=TIMING)


def sampled_path():
    """Mode and low-pass as python-control samples them, at z = exp(jwh)."""
    w = 2.0 * np.pi * FREQUENCY
    mode = control.tf([1.0 + GAIN, 2.0 * DAMPING * w, w * w], [1.0, 2.0 * DAMPING * w, w * w])
    mode = control.sample_system(mode, H, method="bilinear", prewarp_frequency=w)
    c = 2.0 * np.pi * CUTOFF
    smooth = control.tf([c * c], [1.0, np.sqrt(2.0) * c, c * c])
    smooth = control.sample_system(smooth, H, method="bilinear", prewarp_frequency=c)
    return (mode * smooth)(np.exp(1j * W * H))


@pytest.mark.parametrize("channel", ["roll", "pitch", "yaw"])
def test_the_part_of_the_loop_that_is_rate_goes_through_them(channel):
    """L is the part of the angle, which no gyro measures, plus the part of the rate times mode and low-pass."""
    (whole,), (angle,) = (gains_with("pid", "pid", **change) for change in ({}, {f"{channel}__kd": 0.0}))
    rigid, flexible = model(HUMMINGBIRD), model(FLEXIBLE)
    of_angle = rigid.loop(angle, channel, frequency=W).loop
    of_rate = rigid.loop(whole, channel, frequency=W).loop - of_angle
    found = flexible.loop(whole, channel, frequency=W).loop
    assert np.abs(sampled_path() - 1.0).max() > 1.0
    assert found == pytest.approx(of_angle + of_rate * sampled_path(), rel=1e-7, abs=1e-12)


@pytest.mark.parametrize("channel", ["roll", "yaw"])
def test_notches_stand_at_the_speed_of_the_trim(channel):
    """At hover, where four rotors turn alike, the rate goes through the same notch four times at each harmonic."""
    (whole,), (angle,) = (gains_with("pid", "pid", **change) for change in ({}, {f"{channel}__kd": 0.0}))
    plain = model(HUMMINGBIRD)
    notched = model(HUMMINGBIRD, replace(OPTIONS["delayed"], rpm_notches=2, rpm_notch_q=3.0, rpm_notch_min=30.0))
    of_angle = plain.loop(angle, channel, frequency=W).loop
    of_rate = plain.loop(whole, channel, frequency=W).loop - of_angle
    hover = np.sqrt(0.25 * HUMMINGBIRD.mass * HUMMINGBIRD.gravity / HUMMINGBIRD.thrust_coefficient)
    through = np.ones(len(W), dtype=complex)
    for w in (hover, 2.0 * hover):
        notch = control.tf([1.0, 0.0, w * w], [1.0, w / 3.0, w * w])
        notch = control.sample_system(notch, H, method="bilinear", prewarp_frequency=w)
        through *= notch(np.exp(1j * W * H)) ** 4
    found = notched.loop(whole, channel, frequency=W).loop
    assert np.abs(through).min() < 0.1
    # Poles that four notches share leave a realisation fewer digits.
    assert found == pytest.approx(of_angle + of_rate * through, rel=1e-5, abs=1e-9)


def test_lines_of_the_rotors_are_no_feedback():
    """Margins of a vehicle that vibrates are those of one that does not, to the bit."""
    gains = gains_with("pid", "pid")
    loud, quiet = (model(vehicle).evaluate(gains) for vehicle in (FLEXIBLE._replace(vibration_1=0.3), FLEXIBLE))
    assert np.array_equal(loud.phase.value, quiet.phase.value)
    assert np.array_equal(loud.delay.value, quiet.delay.value)
