"""Forecasts against printed outcomes, and factors that follow from 1/b0."""

import numpy as np
import pytest

from tests.tuner.extensions.betaflight_adrc.flown_logs import IN_FLIGHT, fly_axis
from tuner.extensions.betaflight_adrc import equations
from tuner.extensions.betaflight_adrc.linear_loop import AxisPlant, Sampling, margins, scaled
from tuner.extensions.betaflight_adrc.ringing import changes, plants_of_b0, rings, worst_ring
from tuner.extensions.betaflight_adrc.settings import AXES, BUILDS, default_tune

SAMPLING = Sampling(312e-6, 312e-6, ())


def tune_of(build="b11", **numbers):
    return default_tune(BUILDS[build]).with_numbers({f"adrc_{name}": float(value) for name, value in numbers.items()})


@pytest.mark.parametrize(("b0", "rings_in_flight"), [(1000, True), (2000, False), (4000, False)])
def test_a_craft_of_5_in_rings_at_half_its_b0(b0, rings_in_flight):
    """Printed at 40/100: a limit cycle at 22 Hz with b0 1000, quiet with 2000 and 4000; plant by chirp of its sister."""
    tune = tune_of("b10.1", wc_roll=40, wo_roll=100, b0_roll=b0)
    margin = margins(tune, "roll", AxisPlant(73.0, 0.020, 0.0023), Sampling(125e-6, 125e-6, (250.0, 500.0)))
    assert (margin.gain < 1.0) == rings_in_flight and 22.0 < margin.ring < 29.0


@pytest.mark.parametrize(
    ("wc", "wo", "b0", "lifts"),
    [
        (40, 140, 2500, False),
        (20, 140, 2500, False),
        (5, 110, 5378, False),
        (103, 140, 2500, True),
        (99, 110, 5378, True),
    ],
)
def test_a_ground_tune_lifts_where_its_margin_is_below_1(wc, wo, b0, lifts):
    """Tap tests of a 65 mm craft on the ground, its b0 of 3852 by chirp."""
    tune = tune_of(wc_pitch=wc, wo_pitch=wo, b0_pitch=b0, ground_wc=wc, ground_dgain=0)
    plants = plants_of_b0(tune.with_numbers({"adrc_b0_pitch": 3852.0}))
    assert (margins(tune, "pitch", plants["pitch"], SAMPLING, 1.0, False).gain < 1.0) == lifts


@pytest.mark.parametrize(("axis", "gate"), [("yaw", IN_FLIGHT), ("pitch", equations.SHUT), ("yaw", equations.SHUT)])
def test_loops_ring_in_time_beyond_their_margin(axis, gate):
    """Simulated rate loops with noise, gate open and shut: 8 % below the margin quiet, 8 % above it at the limit of the motors."""
    numbers = {f"wc_{axis}": 70, f"wo_{axis}": 110, f"b0_{axis}": 3000, "ground_wc": 70, "ground_dgain": 0}
    tune = tune_of("b11", **numbers)
    plant, still = plants_of_b0(tune)[axis], np.zeros(16000)
    margin = margins(tune, axis, plant, SAMPLING, 1.0, gate.is_open > 0.5)
    swings = []
    for factor in (0.92, 1.08):
        loop = scaled(plant, factor * margin.gain)
        rate = fly_axis(tune, axis, loop, SAMPLING, still, np.random.default_rng(1), gate)[1][8000:]
        swings.append(float(np.std(rate)))
    power = np.abs(np.fft.rfft(rate - rate.mean()))
    assert swings[1] > 8.0 * swings[0]
    assert np.argmax(power) / (len(rate) * SAMPLING.period) == pytest.approx(margin.ring, abs=0.06 * margin.ring)


def test_margins_by_throttle_follow_the_schedules():
    tune = tune_of(hover_throttle=20)
    plants = {"yaw": plants_of_b0(tune)["yaw"]}
    found = {
        (ring.schedule, ring.throttle): ring.gain_margin or 0.0
        for ring in rings(tune, plants, SAMPLING)
        if ring.gate == "open"
    }
    hover = found["SQRT", 0.2]
    # At four times the collective of hover the rotors have twice the gain.
    assert found["SQRT", 0.8] == pytest.approx(hover, rel=1e-6)
    assert found["FIXED", 0.8] == pytest.approx(hover / 2.0, rel=1e-6)
    assert found["LINEAR", 0.8] == pytest.approx(hover * 3.0 / 2.0, rel=1e-6)


def test_the_axis_that_rings_is_yaw_and_a_larger_b0_costs_stiffness():
    sweep = {f"{name}_{axis}": value for axis in AXES for name, value in (("wc", 97), ("wo", 110))}
    tune = tune_of("b11", **sweep)
    plants = plants_of_b0(tune)
    ring = worst_ring(list(rings(tune, plants, SAMPLING)), "FIXED")
    assert ring.axis == "yaw" and ring.ring is not None and 55.0 < ring.ring < 65.0 and ring.gain_margin is not None
    options = changes(tune, plants["yaw"], SAMPLING, ring, 0.5)
    by_b0 = next(change for change in options if change.settings == {"adrc_b0_yaw": 2500.0})
    assert by_b0.gain_margin == pytest.approx(1.25 * ring.gain_margin, rel=1e-6)
    assert by_b0.stiffness == pytest.approx(0.8, rel=1e-6) and by_b0.noise == pytest.approx(0.8, rel=1e-6)
    gains = [change.gain_margin for change in options]
    assert gains == sorted(gains, reverse=True) and gains[0] > ring.gain_margin
