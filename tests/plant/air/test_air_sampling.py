"""The air of a scenario: frames, window, gust, injection, and what its bits depend on."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import welch

from plant.air.air import COLUMNS, AirSpec, draw_air, summary
from plant.air.gust import Gust
from plant.air.injection import Injection
from plant.air.intensity import scales
from plant.air.window import gate
from plant.seeds import generator
from tests.plant.air.spectra import phi_p, phi_q, phi_r, phi_u, phi_v, phi_w

DT, STEPS = 0.004, 1250
NOISE = Injection(acceleration_sigma=(1.0, 2.0, 0.5), angular_sigma=(3.0, 0.0, 1.0), angular_bias=(0.0, 0.25, 0.0))
FULL = AirSpec(wind_direction_deg=30.0, angular_rates=True, gust=Gust(2.0, 1.0, 1.0, "w"), injection=NOISE)


def draw(spec, index=0, steps=STEPS, dt=DT):
    out = np.empty((steps, COLUMNS))
    draw_air(spec, dt, generator(7, "search", index), out)
    return out


def turned_back(air, degrees):
    """Wind columns in wind axes, by complex numbers."""
    horizontal = (air[:, 0] + 1j * air[:, 1]) * np.exp(-1j * np.deg2rad(degrees))
    return np.stack([horizontal.real, horizontal.imag, air[:, 2]], axis=1)


def test_same_arguments_same_bits_and_other_index_other_air():
    assert np.array_equal(draw(FULL, 3), draw(FULL, 3))
    assert np.array_equal(draw(replace(FULL), 3), draw(FULL, 3))
    assert not np.any(draw(FULL, 3)[:, 0] == draw(FULL, 4)[:, 0])


def test_shape_and_columns():
    air = draw(FULL)
    assert air.shape == (STEPS, 12)
    assert air.dtype == np.float64
    assert np.isfinite(air).all(axis=None)
    assert (air.std(axis=0) > 0.0).tolist() == [True] * 10 + [False, True]  # the pitch injection has sigma 0


def test_switching_an_option_leaves_the_bits_of_the_others():
    air, wind, rates, injected = draw(FULL), slice(0, 3), slice(3, 6), slice(6, 12)
    without = draw(replace(FULL, angular_rates=False))
    assert np.array_equal(without[:, wind], air[:, wind])
    assert not without[:, rates].any()
    assert np.array_equal(without[:, injected], air[:, injected])
    without = draw(replace(FULL, injection=None))
    assert np.array_equal(without[:, :6], air[:, :6])
    assert not without[:, injected].any()
    assert np.array_equal(draw(replace(FULL, intensity="none"))[:, injected], air[:, injected])
    assert np.array_equal(draw(replace(FULL, gust=None))[:, 3:], air[:, 3:])
    quiet = replace(NOISE, acceleration_sigma=(0.0, 2.0, 0.5))
    assert np.array_equal(draw(replace(FULL, injection=quiet))[:, 7:], air[:, 7:])


def test_a_longer_run_begins_with_the_bits_of_a_shorter_one():
    assert np.array_equal(draw(FULL, steps=2 * STEPS)[:STEPS], draw(FULL))


def test_both_specifications_give_the_same_bits():
    assert np.array_equal(draw(replace(FULL, spec="1797")), draw(FULL))


def test_intensity_only_scales_where_the_airspeed_is_the_same():
    light, severe = (
        AirSpec(intensity=x, wind_direction_deg=0.0, mean_wind=False, minimum_airspeed=40.0)
        for x in ("light", "severe")
    )
    np.testing.assert_allclose(draw(severe), 3.0 * draw(light), rtol=1e-12)


def test_the_direction_is_where_the_wind_blows_to():
    still = AirSpec(intensity="none", gust=Gust(-3.0, 0.0, 2.0, "u"))
    peak = round(1.0 / DT)
    for degrees, expected in ((0.0, (-3.0, 0.0, 0.0)), (90.0, (0.0, -3.0, 0.0)), (210.0, (1.5 * 3**0.5, 1.5, 0.0))):
        air = draw(replace(still, wind_direction_deg=degrees))
        np.testing.assert_allclose(air[peak, :3], expected, atol=1e-12)
    left = draw(replace(still, wind_direction_deg=90.0, gust=Gust(3.0, 0.0, 2.0, "v")))
    np.testing.assert_allclose(left[peak, :3], (-3.0, 0.0, 0.0), atol=1e-12)  # left of north is west


def test_turning_the_wind_turns_wind_and_rates_rigidly():
    east, turned = (draw(replace(FULL, wind_direction_deg=x, gust=None)) for x in (0.0, 110.0))
    np.testing.assert_allclose(turned_back(turned, 110.0), east[:, :3], atol=1e-12)
    np.testing.assert_allclose(turned_back(turned[:, 3:], 110.0), east[:, 3:6], atol=1e-12)
    assert np.array_equal(turned[:, 6:], east[:, 6:])


def test_drawn_directions_are_uniform():
    spec = AirSpec(intensity="none", gust=Gust(1.0, 0.0, 2.0 * DT))
    wind = np.array([draw(spec, i, steps=3)[1, :2] for i in range(1500)])
    assert np.hypot(wind[:, 0], wind[:, 1]) == pytest.approx(1.0)
    angle = np.arctan2(wind[:, 1], wind[:, 0])
    for k in (1, 2, 3):  # trigonometric moments vanish; each has a standard deviation of sqrt(1 / (2 * 1500)) = 1.8 %
        assert abs(np.cos(k * angle).mean(axis=0)) < 0.09
        assert abs(np.sin(k * angle).mean(axis=0)) < 0.09


def test_mean_wind_blows_unless_switched_off():
    spec = AirSpec(wind_direction_deg=0.0)
    difference = draw(spec)[:, :3] - draw(replace(spec, mean_wind=False))[:, :3]
    np.testing.assert_allclose(
        difference, np.broadcast_to([summary(spec)["mean_wind"], 0.0, 0.0], (STEPS, 3)), atol=1e-12
    )


@pytest.mark.slow
def test_stationary_from_the_first_sample():
    """Over 3000 scenarios, first and last of 2.5 s alike: relative deviation sqrt(2 / 3000) = 2.6 %, five of them."""
    spec = AirSpec(wind_direction_deg=0.0, angular_rates=True, mean_wind=False)
    ensemble = np.array([draw(spec, i, steps=26, dt=0.1)[[0, 25]] for i in range(3000)])
    field = spec.field
    expected = [
        quad(lambda x, phi=phi: phi(x, field), 0.0, np.inf)[0] for phi in (phi_u, phi_v, phi_w, phi_p, phi_q, phi_r)
    ]
    for instant in (0, 1):
        np.testing.assert_allclose(ensemble[:, instant, :6].var(axis=0), expected, rtol=0.13)
        # Independent axes: a correlation varies by 1 / sqrt(3000) = 1.8 %, five of them.
        for independent in (slice(0, 3), slice(3, 6)):
            correlation = np.corrcoef(ensemble[:, instant, independent], rowvar=False) - np.eye(3)
            assert np.abs(correlation).max(axis=None) < 0.092
    # The first sample says what the last one will be: R(2.5 s) = exp(-2.5 / tau_u), deviation at most sqrt(2 / 3000).
    correlation = np.mean(ensemble[:, 0, 0] * ensemble[:, 1, 0]) / field.sigma[0] ** 2
    assert correlation == pytest.approx(np.exp(-2.5 / field.tau[0]), abs=0.13)


@pytest.mark.parametrize("dt", [0.02, 0.05, 0.2])
def test_variance_and_spectrum_of_the_wind_at_three_steps(dt):
    """Through the public function, 2^18 steps: w at hover in light air has sigma 0.77 m/s and L / V = 1.18 s."""
    spec = AirSpec(wind_direction_deg=0.0)
    w = draw(spec, steps=2**18, dt=dt)[:, 2]
    sigma, tau = 0.1 * 15.0 * 0.514444, 10.0 / 8.49727
    # The sample variance varies by (2 / T) int R^2 / sigma^4 over all lags = 1.25 tau / T, plus 2 / n near dt = tau.
    deviation = np.sqrt((1.25 * tau / dt + 2.0) / len(w))
    assert w.var(axis=0) == pytest.approx(sigma**2, rel=5.0 * deviation)
    frequency, density = welch(w, 1.0 / dt, nperseg=8192)
    band = (frequency > 0.02 / tau) & (frequency < 0.3 / tau)
    square = (2.0 * np.pi * frequency[band] * tau) ** 2
    ratio = density[band] / (2.0 * sigma**2 * tau * (1.0 + 3.0 * square) / (1.0 + square) ** 2)
    # 32 segments' worth, half overlapping, Hann: sqrt(0.53 * 1.94 / (32 * bins)); 1 % for folding and leakage.
    assert abs(ratio.mean(axis=0) - 1.0) < 5.0 * np.sqrt(0.53 * 1.94 / (32 * len(ratio))) + 0.01


def test_one_path_at_two_steps_by_taking_every_second_row():
    """Sub-sampling keeps the law: differences over 2 dt of the fine path and over one step of a coarse one agree."""
    spec = AirSpec(wind_direction_deg=0.0, mean_wind=False)
    fine = draw(spec, steps=2**18, dt=0.01)[::2, 2]
    coarse = draw(spec, 1, steps=2**17, dt=0.02)[:, 2]
    spread = [np.mean(np.diff(x) ** 2) for x in (fine, coarse)]
    # 131072 nearly independent increments each: relative deviation of the ratio 2 sqrt(1 / 131072) = 0.55 %.
    assert spread[0] == pytest.approx(spread[1], rel=0.028)


def test_window_shape():
    time = np.array([0.9, 1.0, 1.125, 1.25, 2.0, 2.75, 2.875, 3.0, 3.1])
    np.testing.assert_allclose(gate(time, (1.0, 3.0)), [0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0], atol=1e-12)
    assert (gate(time, None) == 1.0).all(axis=0)
    fine = np.linspace(0.0, 4.0, 40001)
    step = np.abs(np.diff(gate(fine, (1.0, 3.0)))).max(axis=0)
    assert step == pytest.approx(0.5 * np.pi / 0.25 * 1e-4, rel=1e-3)  # steepest at half height: pi / (2 * 0.25 s)


def test_window_gates_turbulence_and_noise_but_not_mean_wind_gust_or_bias():
    windowed = replace(FULL, window=(1.0, 3.0), gust=Gust(2.0, 3.5, 1.0, "w"))
    air, plain = draw(windowed), draw(replace(windowed, window=None))
    time = np.arange(STEPS) * DT
    outside, inside = (time <= 1.0) | (time >= 3.0), (time > 1.26) & (time < 2.74)
    assert np.array_equal(air[inside], plain[inside])
    calm = draw(replace(windowed, window=None, intensity="none", injection=None))
    mean = turned_back(air, 30.0)[outside] - turned_back(calm, 30.0)[outside]
    np.testing.assert_allclose(mean, np.broadcast_to([summary(FULL)["mean_wind"], 0.0, 0.0], mean.shape), atol=1e-12)
    assert not air[outside, 3:6].any()
    np.testing.assert_array_equal(
        air[outside, 6:], np.broadcast_to([0.0, 0.0, 0.0, 0.0, 0.25, 0.0], (outside.sum(), 6))
    )


def test_gust_pulse():
    air = draw(AirSpec(intensity="none", gust=Gust(4.0, 1.0, 2.0, (0.0, 3.0, -4.0))))
    time, along = np.arange(STEPS) * DT, air[:, :3] @ [0.0, 0.6, -0.8]
    np.testing.assert_allclose(air[:, :3], along[:, None] * np.array([0.0, 0.6, -0.8]), atol=1e-15)
    np.testing.assert_allclose(along[[250, 375, 500, 625, 750]], [0.0, 2.0, 4.0, 2.0, 0.0], atol=1e-12)
    assert not along[(time < 1.0) | (time > 3.0)].any()
    assert along.sum() * DT == pytest.approx(4.0 * 2.0 / 2.0)  # half the peak on average over its length
    assert not air[:, 3:].any()


def test_injection_statistics():
    """Each axis: its sigma, its correlation time, its bias; 2^18 steps of 0.05 s."""
    injection = Injection(
        (1.0, 2.0, 0.5), (0.5, 1.0, 2.0), (0.0, -1.0, 3.0), (4.0, 5.0, 6.0), (0.2, 0.4, 0.8), (1.0, 0.0, -2.0)
    )
    air = draw(AirSpec(intensity="none", injection=injection), steps=2**18, dt=0.05)[:, 6:]
    sigma, time = np.array([1.0, 2.0, 0.5, 4.0, 5.0, 6.0]), np.array([0.5, 1.0, 2.0, 0.2, 0.4, 0.8])
    centred = (air - [0.0, -1.0, 3.0, 1.0, 0.0, -2.0]) / sigma
    duration = 2**18 * 0.05
    # Standard deviations over a duration T: mean sqrt(2 tau / T), covariance at most sqrt(2 (tau + dt) / T).
    assert (np.abs(centred.mean(axis=0)) < 5.0 * np.sqrt(2.0 * time / duration)).all(axis=0)
    assert (np.abs(centred.var(axis=0) - 1.0) < 5.0 * np.sqrt(2.0 * (time + 0.05) / duration)).all(axis=0)
    at_lag = np.mean(centred[4:] * centred[:-4], axis=0) - np.exp(-0.2 / time)
    assert (np.abs(at_lag) < 5.0 * np.sqrt(2.0 * (time + 0.05) / duration)).all(axis=0)
    correlation = np.corrcoef(centred, rowvar=False) - np.eye(6)
    assert np.abs(correlation).max(axis=None) < 5.0 * np.sqrt((time.max(axis=0) + 0.05) / duration)


def test_summary_states_what_is_flown():
    stated = summary(AirSpec(intensity=3.0, altitude=6.096, vehicle_speed=-1.0, spec="1797"))
    length, sigma = scales("1797", 3.0, 6.096)
    assert stated["mean_wind"] == pytest.approx(3.0)
    assert stated["airspeed"] == pytest.approx(4.0)
    assert [stated[f"length_{x}"] for x in "uvw"] == list(length)
    assert [stated[f"sigma_{x}"] for x in "uvw"] == list(sigma)
    assert stated["tau_w"] == pytest.approx(6.096 / 4.0)
    assert stated["frozen_field_ratio"] == pytest.approx(sigma[0] / 4.0)
    assert "tau_p" not in stated
    assert summary(AirSpec(angular_rates=True))["tau_r"] == pytest.approx(3.0 * 0.342 / (np.pi * 8.49727), rel=1e-5)


def test_calm_air_is_exactly_zero():
    assert not draw(AirSpec(intensity="none")).any()
    assert not draw(AirSpec(intensity=0)).any()
