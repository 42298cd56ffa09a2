"""Spectra of commands, against closed forms, and against the metric that counts the same noise."""

from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from objectives.margins.period import NO_METERS
from objectives.metrics.noise import CUTOFF
from objectives.problem import FlightBatch
from plant.law_registry import LAWS
from plant.laws.filters import stage_share
from plant.loop import Timing
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import close_loop
from plant.quadrotor.scenarios import HELD_OUT
from tuner.analysis.spectrum import command_spectrum, spectrum
from tuner.experiments.tuning.problem import problem_of
from tuner.study.build import load_study

ROOT = Path(__file__).parents[3]
H = 0.002
WHITE = np.random.default_rng(4).normal(0.0, 0.3, (24, 5000, 4))


def test_white_noise_is_flat():
    """Its one-sided power density is twice its variance over the rate; a band is known to some 2 % of 24 x 4 x 9 segments."""
    found = spectrum(WHITE, H)
    assert found is not None
    assert found.density == pytest.approx(0.3 * np.sqrt(2.0 * H), rel=0.1)
    assert np.sqrt(np.mean(found.density**2, axis=0)) == pytest.approx(0.3 * np.sqrt(2.0 * H), rel=0.02)
    assert np.all(np.diff(found.frequency) > 0.0) and found.frequency[-1] == pytest.approx(0.5 / H, rel=0.05)


def test_a_tone_stands_where_it_is():
    """Its power over the bands is half the square of its amplitude."""
    t = H * np.arange(5000)
    tone = np.broadcast_to(0.2 * np.sin(2.0 * np.pi * 90.0 * t)[None, :, None], (2, 5000, 4))
    found = spectrum(tone, H)
    assert found is not None
    assert found.frequency[np.argmax(found.density, axis=0)] == pytest.approx(90.0, rel=0.04)


def test_nothing_is_said_of_no_flights_or_of_a_few_samples():
    assert spectrum(WHITE[:0], H) is None
    assert spectrum(WHITE[:, :10], H) is None and spectrum(WHITE, 0.1) is None


def test_flights_that_are_lost_are_left_out():
    """One of four flights ends; commands after it are not the controller's any more."""

    class System:
        loop = close_loop(close_cascade(LAWS["pid"], LAWS["pid"]), NO_METERS)
        command, command_scales, nominal, timing = "pending", np.ones(4), None, Timing(H, H)

    class Recorder:
        def trace(self, gains, nominal, inputs, every, traced):
            status = np.zeros((4, 5000, 1))
            status[2, 1000:] = 1.0
            return np.concatenate([WHITE[:4], status], axis=2)

    found = command_spectrum(cast("Any", System()), cast("Any", Recorder()), np.zeros(1), cast("Any", None))
    expected = spectrum(WHITE[[0, 1, 3]], H)
    assert found is not None and expected is not None
    assert np.array_equal(found.density, expected.density)


@pytest.mark.slow
def test_the_spectrum_holds_what_the_metric_counts():
    """The metric's high-pass over the spectrum gives the metric: two ways to the same noise, one of them in the kernel."""
    study = load_study(ROOT / "studies/ardupilot.toml", {"scenario.0.duration": 20.0})
    system, spec = study.system, study.scenarios[0].spec
    problem, row = problem_of(study, 2, None), np.array(study.space.base)
    found = command_spectrum(system, problem.flyer, row, system.sample(spec, study.seed, HELD_OUT, range(16)))
    assert found is not None
    h = system.timing.control_period
    s = stage_share(CUTOFF, h)
    z = np.exp(2j * np.pi * found.frequency * h)
    passed = np.abs((1.0 - s) * (1.0 - 1.0 / z) / (1.0 - (1.0 - s) / z)) ** 2
    power = np.trapezoid(passed * found.density**2, found.frequency)
    scores = problem.evaluate_gains(row[None], (FlightBatch(spec, HELD_OUT, 16),), fly_all=True).scores
    index = next(i for i, entry in enumerate(study.objectives) if entry.metric.text == "noise")
    assert np.sqrt(power) == pytest.approx(np.sqrt(np.mean(scores[0, index] ** 2)), rel=0.1)
