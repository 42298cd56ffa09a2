"""Scale lengths, intensities and mean wind against tabulated numbers."""

from math import log

import numpy as np
import pytest

from plant.air.intensity import scales, wind_at_20_feet
from plant.air.mean_wind import effective_airspeed, mean_wind_speed
from plant.errors import InputError

FOOT = 0.3048
# MIL-F-8785C at low altitude: h, Lu, Lw [m], then sigma_u of light, moderate, severe and sigma_w of the same [m/s].
TABLE = [
    (3.048, 23.05, 3.05, 1.515, 3.030, 4.544),
    (6.096, 43.77, 6.10, 1.489, 2.977, 4.466),
    (10.0, 67.37, 10.0, 1.457, 2.915, 4.372),
    (20.0, 116.06, 20.0, 1.387, 2.773, 4.160),
    (30.0, 152.46, 30.0, 1.327, 2.653, 3.980),
    (50.0, 202.29, 50.0, 1.230, 2.459, 3.689),
    (100.0, 262.79, 100.0, 1.065, 2.130, 3.195),
    (304.8, 304.8, 304.8, 0.772, 1.543, 2.315),
]


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row[0]} m")
def test_low_altitude_table(row):
    altitude, length_u, length_w, *sigma_u = row
    for name, sigma, sigma_w in zip(("light", "moderate", "severe"), sigma_u, (0.772, 1.543, 2.315), strict=True):
        got = scales("8785C", name, altitude)
        assert got.length == pytest.approx((length_u, length_u, length_w), abs=6e-3)
        # half a unit of the last digit printed, and a little for a value that lies on the edge
        assert got.sigma == pytest.approx((sigma, sigma, sigma_w), abs=6e-4)


def test_below_ten_feet_the_model_stands_still():
    assert scales("8785C", "light", 0.5) == scales("8785C", "light", 3.048)
    assert scales("8785C", "light", 3.2) != scales("8785C", "light", 3.048)


@pytest.mark.parametrize("altitude", [2.0, 10.0, 300.0, 400.0, 700.0, 5000.0])
def test_1797_halves_the_transverse_lengths_only(altitude):
    c, h = scales("8785C", "moderate", altitude), scales("1797", "moderate", altitude)
    assert h.sigma == c.sigma
    assert h.length == pytest.approx((c.length[0], c.length[1] / 2.0, c.length[2] / 2.0), rel=1e-15)


def test_high_altitude_reads_the_exceedance_curves():
    for name, at_2000, at_7500, at_20000 in (
        ("light", 6.9625, 6.7, 3.65),
        ("moderate", 9.725, 10.1, 7.3),
        ("severe", 18.275, 23.6, 21.05),
    ):
        for feet, sigma in ((2000.0, at_2000), (7500.0, at_7500), (20000.0, at_20000)):
            got = scales("8785C", name, feet * FOOT)
            assert got.length == pytest.approx((533.4,) * 3, rel=1e-12)
            assert got.sigma == pytest.approx((sigma * FOOT,) * 3, rel=1e-9)


def test_transition_is_linear_and_continuous():
    low, middle, high = (scales("8785C", "severe", feet * FOOT) for feet in (1000.0, 1250.0, 2000.0))
    assert middle.length == pytest.approx((1187.5 * FOOT,) * 3, rel=1e-12)
    np.testing.assert_allclose(middle.sigma, 0.75 * np.array(low.sigma) + 0.25 * np.array(high.sigma), rtol=1e-12)
    for feet, edge in ((1000.0, low), (2000.0, high)):
        for side in (-1e-6, 1e-6):
            near = scales("8785C", "severe", (feet + side) * FOOT)
            np.testing.assert_allclose(near, edge, rtol=1e-7)


def test_a_number_is_the_wind_at_20_feet():
    assert wind_at_20_feet("light") == pytest.approx(7.71667, abs=1e-5)
    assert scales("8785C", wind_at_20_feet("severe"), 25.0) == scales("8785C", "severe", 25.0)
    assert scales("8785C", 4.0, 10.0).sigma[2] == pytest.approx(0.4)
    assert scales("8785C", 0, 10.0).sigma == (0.0, 0.0, 0.0) == scales("8785C", "none", 3000.0).sigma
    assert scales("8785C", 0.0, 3000.0).sigma == (0.0, 0.0, 0.0)


def test_a_number_has_no_exceedance_curve():
    with pytest.raises(InputError, match=r"304\.8 m.*light") as caught:
        scales("8785C", 5.0, 305.0)
    assert caught.value.key == "intensity"


@pytest.mark.parametrize(("roughness", "z0"), [("A", 2.0), ("B", 2.0), ("C", 0.15)])
def test_mean_wind_profile(roughness, z0):
    assert mean_wind_speed(7.0, 20.0 * FOOT, roughness) == pytest.approx(7.0, rel=1e-12)
    # A log profile adds the same speed with each doubling of height: W20 ln 2 / ln(20 / z0).
    gain = 7.0 * log(2.0) / log(20.0 / z0)
    for altitude in (5.0, 10.0, 40.0):
        doubled = mean_wind_speed(7.0, 2.0 * altitude, roughness) - mean_wind_speed(7.0, altitude, roughness)
        assert doubled == pytest.approx(gain, rel=1e-12)


def test_mean_wind_holds_its_ends_and_stays_positive():
    assert mean_wind_speed(7.0, 0.01, "B") == mean_wind_speed(7.0, 3.0 * FOOT, "B") > 0.0
    assert mean_wind_speed(7.0, 9000.0, "C") == mean_wind_speed(7.0, 304.8, "C")
    assert mean_wind_speed(0.0, 10.0, "C") == 0.0


def test_airspeed_rule():
    assert effective_airspeed(0.0, 8.5, 1.5) == 8.5  # hover: the field drifts past
    assert effective_airspeed(8.0, 8.5, 1.5) == 1.5  # carried along: the floor
    assert effective_airspeed(-5.0, 8.5, 1.5) == 13.5  # into the wind
    assert effective_airspeed(12.0, 8.5, 1.5) == 3.5  # faster than the wind
    assert effective_airspeed(0.0, 0.0, 2.0) == 2.0
