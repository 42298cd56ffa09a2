"""Noise to the motors: against closed forms of the sampled high-pass, on commands of rotors and of a plant's inputs."""

from math import pi, sqrt

import numpy as np
import pytest

from objectives.metrics import parse
from objectives.metrics.noise import CUTOFF, Noise, start, update
from objectives.metrics.over_inputs import over_inputs
from objectives.metrics.registry import METRICS
from objectives.problem import FlightBatch
from plant.vectors import Rotors
from tests.objectives.flying import fly, score, targets
from tests.objectives.metrics.test_own_meters import FLIGHTS, scores
from tuner.api.studies import load_study
from tuner.study.plant_study import PlantStudy

H = 0.0005


def noise_of(command, periods):
    """The metric of a flight whose rotors get command(k), one array of four a period."""
    duration = periods * H
    flown = fly({}, targets(), duration, H, lambda k: Rotors(*command(max(k, 0))))
    return score("noise", flown, targets(), duration, H)


def through(frequency):
    """Gain of the sampled high-pass at a frequency [Hz]."""
    share = 2.0 * pi * CUTOFF * H / (1.0 + 2.0 * pi * CUTOFF * H)
    z = np.exp(2j * pi * frequency * H)
    return abs((1.0 - share) * (1.0 - 1.0 / z) / (1.0 - (1.0 - share) / z))


def test_of_white_noise_it_is_what_the_filter_lets_through():
    rng = np.random.default_rng(3)
    drawn = 1.0 + 0.05 * rng.standard_normal((20_000, 4))
    kept = 1.0 / (1.0 + 2.0 * pi * CUTOFF * H)
    # Sum of the squares of the impulse response kept (1, kept - 1, kept (kept - 1), ...).
    expected = 0.05 * kept * sqrt(2.0 / (1.0 + kept))
    assert noise_of(lambda k: drawn[k], len(drawn)) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("frequency", [*(pytest.param(each, marks=pytest.mark.slow) for each in (2.0, 200.0)), 20.0])
def test_of_a_sine_it_is_its_root_mean_square_times_the_gain(frequency):
    waves = np.sin(2.0 * pi * frequency * H * np.arange(20_000))
    found = noise_of(lambda k: 1.0 + 0.1 * waves[k] * np.array([1.0, -1.0, 1.0, -1.0]), len(waves))
    assert found == pytest.approx(0.1 / sqrt(2.0) * through(frequency), rel=2e-3)
    assert found < 0.01 if frequency < CUTOFF / 5.0 else found > 0.04


def test_one_rotor_of_four_counts_half():
    waves = np.sin(2.0 * pi * 100.0 * H * np.arange(4000))
    every = noise_of(lambda k: 1.0 + 0.1 * waves[k] * np.ones(4), len(waves))
    alone = noise_of(lambda k: 1.0 + 0.1 * waves[k] * np.array([0.0, 0.0, 1.0, 0.0]), len(waves))
    assert alone == pytest.approx(0.5 * every, rel=1e-12)


def test_a_steady_command_makes_none():
    assert noise_of(lambda k: np.full(4, 1.3), 100) == 0.0


def test_inputs_of_a_plant_count_in_their_scales():
    accumulator = METRICS["noise"].accumulator
    assert accumulator is not None
    whole = over_inputs(accumulator, {"a": 2.0, "b": 0.5})
    alone = [Noise(0.0, 0.0)] * 2

    class Command:
        a, b = 3.0, -1.0

    class Sample:
        command = Command()

    kept = whole.update(whole.Record(*alone), Sample(), None, H)
    assert kept == tuple(update(each, command, H) for each, command in zip(alone, (1.5, -2.0), strict=True))
    assert whole.start(Sample(), None) == (start(1.5), start(-2.0))


@pytest.mark.slow
def test_a_plant_is_judged_by_it():
    study = load_study("dc_motor", kind=PlantStudy)
    batch = FlightBatch(study.scenarios[0].spec, "search", FLIGHTS)
    noise, peak = scores(
        study.system, (parse("noise", study.system.axes), parse("command_peak")), batch, study.default_row
    )
    assert (noise > 0.0).all() and (noise < peak).all()
