"""Excitations against what others know of chirps, and the reference that a flight makes of them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import chirp

from plant.references.spec import HOLD, PITCH, ROLL, YAW, YAW_RATE
from tuner.extensions.flight_plans.choosing import quantize_amplitude
from tuner.extensions.flight_plans.excitation import LEAD, PAUSE, TAIL, Excitation, Shape, begins, length_of, references

PERIOD = 0.004
TIME = PERIOD * np.arange(2500.0)
ROLLING = Excitation("roll", "angle", 0.2, 1.0, 12.0, 10.0)
PLAIN = Shape(dwell=0.0, fade_in=0.0, fade_out=0.0, cosine=True)


def test_without_dwell_and_fades_it_is_the_exponential_chirp_of_scipy():
    made = replace(ROLLING, shape=PLAIN).values(TIME)
    assert made == pytest.approx(0.2 * chirp(TIME, 1.0, 10.0, 12.0, method="logarithmic"), abs=1e-9)


def test_it_dwells_for_two_periods_then_sweeps_to_its_last_frequency_and_fades():
    fine = 5e-5 * np.arange(200_001.0)
    values = ROLLING.values(fine)
    crossings = fine[1:][np.diff(np.sign(values)) != 0]
    assert 0.5 / np.diff(crossings[crossings < 1.9]) == pytest.approx(1.0, rel=1e-3)
    assert 0.5 / np.diff(crossings[crossings < 9.9])[-1] == pytest.approx(12.0, rel=0.05)
    assert values[0] == 0.0 and abs(values[-1]) < 1e-9 and np.abs(values).max() == pytest.approx(0.2, rel=1e-3)
    assert not ROLLING.values(np.array([-0.1, 10.1])).any()


def test_doublets_are_the_signs_of_the_chirp():
    made, wave = replace(ROLLING, wave="doublets").values(TIME), ROLLING.values(TIME)
    inside = (TIME > 1.5) & (TIME < 9.0)
    assert np.all(made[inside] * wave[inside] >= 0.0)
    # A sample in which the sign turns holds the mean of both: a flip each half period, of 12 Hz at most.
    assert np.abs(made).max() == pytest.approx(0.2) and np.mean(np.abs(made[inside]) < 0.199) < 24.0 * PERIOD


@pytest.mark.parametrize("duration", [8.0, 60.0])
def test_the_height_of_doublets_stays_about_hover_however_long_they_last(duration):
    """A square wave of an acceleration a swings by a / (32 f^2); the signs of samples let it wander, by 1.02 m in 60 s."""
    samples = references([Excitation("lift", "acceleration", 2.0, 1.0, 6.0, duration, "doublets")], PERIOD)
    assert np.abs(samples[:, 2]).max() == pytest.approx(2.0 / 32.0, rel=0.4)


def test_throttle_steps_are_a_square_wave_from_hover_back_to_hover():
    plain = Shape(dwell=0.0, fade_in=0.0, fade_out=0.0, cosine=True)
    entry = Excitation("lift", "acceleration", 2.0, 0.5, 0.5, 8.0, "steps", plain)
    values = entry.values(TIME)
    assert values[TIME < 0.49] == pytest.approx(2.0) and values[(TIME > 0.51) & (TIME < 1.49)] == pytest.approx(-2.0)
    samples = references([entry], PERIOD)
    assert np.abs(samples[:, 2]).max() == pytest.approx(2.0 / (16.0 * 0.5**2), rel=0.05)
    assert samples[-1, [2, 5]] == pytest.approx([0.0, 0.0], abs=0.01)


def test_the_amplitude_falls_between_the_corners_of_a_lag_lead_filter():
    """(1 + j f / lead) / (1 + j f / lag): Betaflight's chirp goes through it with corners of 3 and 30 Hz."""
    shape = PLAIN._replace(lag=3.0, lead=30.0)
    filtered = Excitation("roll", "angle", 0.2, 0.1, 100.0, 10.0, shape=shape)
    frequency = 0.1 * 1000.0 ** (TIME / 10.0)
    expected = np.abs((1.0 + 1j * frequency / 30.0) / (1.0 + 1j * frequency / 3.0))
    top = np.abs(replace(filtered, shape=PLAIN).values(TIME)) > 0.1
    ratio = filtered.values(TIME)[top] / replace(filtered, shape=PLAIN).values(TIME)[top]
    assert ratio == pytest.approx(expected[top], rel=1e-9)


def test_a_flight_excites_one_axis_after_the_other_with_consistent_references():
    made = (
        ROLLING,
        Excitation("pitch", "rate", 1.0, 1.0, 8.0, 8.0, shape=PLAIN),
        Excitation("yaw", "rate", 0.5, 1.0, 8.0, 8.0),
        Excitation("lift", "acceleration", 2.0, 0.5, 4.0, 12.0),
    )
    samples = references(made, PERIOD)
    assert len(samples) == round(length_of(made) / PERIOD) and not samples[:, HOLD].any()
    assert length_of(made) == LEAD + 38.0 + 4 * PAUSE + TAIL == 51.0
    columns = (ROLL, PITCH, YAW_RATE, 8)
    for entry, begin, column in zip(made, begins(made), columns, strict=True):
        time = PERIOD * np.arange(float(len(samples)))
        inside = (time >= begin) & (time <= begin + entry.duration)
        assert np.abs(samples[inside, column]).max() > 0.0 and not np.any(samples[time < begin, column])
    # Rates and angles, climb and height belong together, and a rate's angle swings about zero.
    assert np.gradient(samples[:, YAW], PERIOD) == pytest.approx(samples[:, YAW_RATE], abs=0.06)
    assert np.gradient(samples[:, 2], PERIOD) == pytest.approx(samples[:, 5], abs=0.06)
    assert np.abs(samples[:, PITCH]).max() == pytest.approx(made[1].angle, rel=0.05)
    assert not samples[-1, [ROLL, 5, 8]].any()


@pytest.mark.parametrize(("degrees", "coarse_degrees"), [(5.74, 5.7), (5.7, 5.7), (5.79, 5.7), (0.02, 0.1)])
def test_an_amplitude_in_whole_steps_is_not_larger_than_it_was(degrees, coarse_degrees):
    """Limits were tried with the amplitude itself; a tenth of a degree is the least that a target takes."""
    given = Excitation("roll", "angle", float(np.radians(degrees)), 0.5, 4.0, 10.0)
    assert np.degrees(quantize_amplitude(given).amplitude) == pytest.approx(coarse_degrees)
