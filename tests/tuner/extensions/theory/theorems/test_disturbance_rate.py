"""The disturbance rate of a scenario: against statistics of known processes, a known gust, and the model on scalars."""

from math import exp, pi

import numpy as np
import pytest
from scipy.stats import norm

from plant.air.gust import Gust
from plant.air.injection import Injection
from plant.air.spec import AirSpec
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.rigid_body import Body, body_rate, dynamics
from plant.quadrotor.scenarios import SEARCH, ScenarioSpec, Spread, sample_scenarios
from plant.records import pack
from plant.vectors import Quaternion, Rotors, Vec3
from tests.plant.loops import TIMING, VEHICLE
from tuner.extensions.theory.theorems.disturbance_rate import (
    SCENARIOS,
    disturbance_rates,
    hovering_disturbance,
    worst_rates,
)

H = TIMING.control_period
LINEAR = VEHICLE._replace(drag_linear=Vec3(0.3, 0.3, 0.2), drag_quadratic=Vec3(0.0, 0.0, 0.0), drag_height=0.1)


def spec(duration=4.0, spread=None, **air):
    return ScenarioSpec("test", duration, air=AirSpec(**air), spread=spread or Spread())


def still_air(**air):
    return spec(intensity="none", mean_wind=False, **air)


def test_injected_noise_has_the_rate_of_its_process():
    # An Ornstein-Uhlenbeck process changes over w by N(0, 2 s^2 (1 - exp(-w/T))).
    injection = Injection((1.0, 2.0, 0.0), (0.5, 0.5, 0.5), (3.0, 0.0, 0.0), (4.0, 0.0, 8.0), (2.0, 2.0, 0.1))
    air = still_air(injection=injection)
    for window, level in ((None, 0.99), (0.1, 0.9)):
        w = window or H
        found = disturbance_rates(air, VEHICLE, TIMING, 5, level, window)
        sizes = zip(injection.sigma, injection.time, strict=True)
        normal = norm.ppf(0.5 + 0.5 * level)
        expected = [normal * s * np.sqrt(2.0 * (1.0 - exp(-w / t))) / w for s, t in sizes]
        # Changes that do not overlap are independent but for w/T: 4 s / w of them in each of 64 scenarios. Four standard errors
        # of the quantile of |N(0, 1)|, 2 to 7 %.
        error = np.sqrt(level * (1.0 - level) / (SCENARIOS * 4.0 / w)) / (2.0 * norm.pdf(normal) * normal)
        np.testing.assert_allclose(found, expected, rtol=4.0 * error)
        assert found[2] == found[4] == 0.0


def test_a_gust_has_the_slope_of_its_pulse():
    # Linear drag: d = D W/m on x, and h_cp D W/I on the pitch axis. The pulse of amplitude A and length T is steepest at pi A/T.
    air = still_air(gust=Gust(5.0, 1.0, 2.0, (1.0, 0.0, 0.0)))
    steepest = pi * 5.0 / 2.0
    found = disturbance_rates(air, LINEAR, TIMING, 5, level=0.9999)
    assert found[0] == pytest.approx(0.3 * steepest / LINEAR.mass, rel=1e-4)
    assert found[4] == pytest.approx(0.1 * 0.3 * steepest / LINEAR.inertia.y, rel=1e-4)
    assert found[[1, 2, 3, 5]].tolist() == [0.0] * 4
    # Half the flight the air is still, so the median is where the pulse begins.
    assert disturbance_rates(air, LINEAR, TIMING, 5, level=0.45)[0] == 0.0


def test_what_does_not_change_has_no_rate():
    biased = still_air(injection=Injection(acceleration_bias=(1.0, 2.0, 3.0), angular_bias=(4.0, 5.0, 6.0)))
    assert not disturbance_rates(biased, VEHICLE, TIMING, 5).any()
    steady = ScenarioSpec("steady", 2.0, air=AirSpec(intensity=0.0, mean_wind=True))
    assert not disturbance_rates(steady, VEHICLE, TIMING, 5).any()


def test_dryden_turbulence_has_no_derivative():
    # The change over w grows as w^(1/2): a window four times as large halves the rate. At 0.064 s there are 8000 changes that do
    # not overlap, so the quantile has a standard error of 1.5 %, and the time constant of the vertical gust, 1.2 s, takes 1.3 %.
    air = spec(8.0, intensity="light", mean_wind=False)
    rates = [disturbance_rates(air, VEHICLE, TIMING, 5, window=w) for w in (0.004, 0.016, 0.064)]
    for shorter, longer in zip(rates, rates[1:], strict=False):
        np.testing.assert_allclose(longer[:5] / shorter[:5], 0.5, rtol=0.073)


def test_the_disturbance_is_what_the_model_makes_of_the_air():
    # One instant of one scenario at a time through the model on plain numbers, vehicle spread included.
    air = spec(
        0.4,
        Spread(mass=0.2, inertia=0.2),
        intensity="severe",
        angular_rates=True,
        injection=Injection((1.0, 1.0, 1.0), angular_sigma=(1.0, 1.0, 1.0)),
    )
    inputs = sample_scenarios(air, VEHICLE, TIMING, 3, SEARCH, range(3))
    found = hovering_disturbance(inputs, VEHICLE)
    assert found.shape == (3, 100, 6)
    speed = (VEHICLE.mass * VEHICLE.gravity / 4.0 / VEHICLE.thrust_coefficient) ** 0.5
    zero, rotors = Vec3(0.0, 0.0, 0.0), Rotors(speed, speed, speed, speed)
    level = Body(zero, zero, Quaternion(1.0, 0.0, 0.0, 0.0), zero, rotors)
    for scenario, instant in ((0, 0), (1, 37), (2, 99)):
        row = inputs.dynamics[0, :, scenario].tolist()
        model = pack(type(dynamics(VEHICLE)), row)
        blown = body_rate(
            level, rotors, pack(Disturbance, inputs.disturbances[0, instant, :, scenario].tolist()), model
        )
        still = body_rate(level, rotors, pack(Disturbance, [0.0] * 12), model)
        expected = np.array([*blown.velocity, *blown.rate]) - np.array([*still.velocity, *still.rate])
        np.testing.assert_allclose(found[scenario, instant], expected, rtol=1e-12, atol=1e-12)


def test_it_is_measured_in_the_flights_of_the_search_and_the_worst_scenario_counts():
    light, severe = spec(intensity="light"), ScenarioSpec("other", 4.0, air=AirSpec(intensity="severe"))
    alone = disturbance_rates(light, VEHICLE, TIMING, 5)
    inputs = sample_scenarios(light, VEHICLE, TIMING, 5, SEARCH, range(SCENARIOS))
    d = hovering_disturbance(inputs, VEHICLE)
    changes = np.abs(np.diff(d, axis=1)) / H
    assert np.array_equal(alone, np.quantile(changes, 0.99, axis=(0, 1), method="inverted_cdf"))
    assert not np.array_equal(alone, disturbance_rates(light, VEHICLE, TIMING, 6))
    worst = worst_rates((light, severe), VEHICLE, TIMING, 5)
    assert list(worst) == ["x", "y", "z", "roll", "pitch", "yaw"]
    assert list(worst.values()) == disturbance_rates(severe, VEHICLE, TIMING, 5).tolist()


def test_rates_that_are_kept_are_those_of_their_level_window_and_seed():
    air = spec(1.0, intensity="light")
    for root, level, window in ((5, 0.99, None), (5, 0.5, None), (5, 0.99, 0.1), (6, 0.99, None), (5, 0.99, None)):
        rates = worst_rates((air,), VEHICLE, TIMING, root, level, window)
        assert list(rates.values()) == disturbance_rates(air, VEHICLE, TIMING, root, level, window).tolist()


def test_of_very_long_flights_fewer_are_looked_at(monkeypatch):
    monkeypatch.setattr("tuner.extensions.theory.theorems.disturbance_rate.SAMPLES", 3500)
    air = spec(4.0, intensity="light")
    inputs = sample_scenarios(air, VEHICLE, TIMING, 5, SEARCH, range(3))
    changes = np.abs(np.diff(hovering_disturbance(inputs, VEHICLE), axis=1)) / H
    expected = np.quantile(changes, 0.99, axis=(0, 1), method="inverted_cdf")
    assert np.array_equal(disturbance_rates(air, VEHICLE, TIMING, 5), expected)
