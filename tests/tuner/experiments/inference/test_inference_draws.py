"""Flights that are drawn from what is kept have the bits of flights that are drawn anew."""

from dataclasses import replace

import numpy as np
import pytest

from plant.air.injection import Injection
from plant.air.spec import AirSpec
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.scenarios import Bands, ScenarioSpec, Spread, sample_scenarios
from plant.quadrotor.sensors import SensorSpec
from tuner.experiments.inference.draws import MAX_CACHED, FlightRange, FlightSampler

TIMING = Timing(0.004, 0.001)
VEHICLE = load("hummingbird").vehicle
SILENT = SensorSpec(position=0.0, velocity=0.0, attitude=0.0, rate=0.0)
INJECTION = Injection(angular_sigma=(1.0, 0.5, 0.1), angular_time=(0.3, 0.2, 0.1), acceleration_bias=(0.0, 0.1, 0.0))
CALM = AirSpec(intensity="none", mean_wind=False, window=(0.0, 0.6))
SPEC = ScenarioSpec("level", 0.8, air=replace(CALM, injection=INJECTION), sensors=SILENT)
SPECS = {
    "injection": SPEC,
    "none": replace(SPEC, air=CALM),
    "silent injection": replace(SPEC, air=replace(CALM, injection=Injection())),
    "wind and noise": replace(SPEC, air=AirSpec(injection=INJECTION), sensors=SensorSpec(), spread=Spread(mass=0.1)),
    "gust rates": replace(SPEC, air=AirSpec(angular_rates=True, injection=INJECTION)),
    "gust rates alone": replace(SPEC, air=AirSpec(angular_rates=True)),
}


def flights(spec, first=0, last=20, stream="search"):
    return FlightRange(spec, VEHICLE, TIMING, stream, first, last)


def same(one, other):
    arrays = ("dynamics", "disturbances", "noises", "references")
    assert one.targets == other.targets
    assert one.count == other.count
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in arrays)


def anew(asked, root=3):
    indices = range(asked.first, asked.last)
    return sample_scenarios(asked.spec, asked.vehicle, asked.timing, root, asked.stream, indices)


@pytest.mark.parametrize("name", SPECS)
def test_same_bits_as_drawn_anew_at_first_and_from_what_is_kept(name):
    draws = FlightSampler(3)
    asked = flights(SPECS[name], 5, 23)
    for _ in range(2):
        assert same(draws.inputs(asked), anew(asked))


def test_settings_one_after_the_other_do_not_disturb_each_other():
    draws = FlightSampler(3)
    for time in (0.3, 0.05, 2.0, 0.3):
        for sigma in (1.0, 4.0):
            injection = replace(INJECTION, angular_time=(time, time, 0.1), angular_sigma=(sigma, 0.0, sigma))
            asked = flights(replace(SPEC, air=replace(SPEC.air, injection=injection)))
            assert same(draws.inputs(asked), anew(asked))
    asked = flights(replace(SPEC, bands=Bands(attitude=0.001), recovery_from=0.3))
    assert same(draws.inputs(asked), anew(asked))
    heavy = replace(asked, vehicle=VEHICLE._replace(mass=1.0))
    assert same(draws.inputs(heavy), anew(heavy))
    for window in (None, (0.1, 0.7)):
        other = flights(replace(SPEC, air=replace(SPEC.air, window=window)))
        assert same(draws.inputs(other), anew(other))


def test_streams_roots_names_and_chunks_are_told_apart():
    draws = FlightSampler(3)
    spec = replace(SPEC, spread=Spread(mass=0.1))
    other = replace(spec, name="b")
    for asked in (flights(spec), flights(spec, 20, 40), flights(spec, stream="held-out"), flights(other)):
        assert same(draws.inputs(asked), anew(asked))
    assert not same(FlightSampler(4).inputs(flights(SPEC)), anew(flights(SPEC)))


def test_what_is_kept_does_not_grow_and_what_is_forgotten_is_drawn_again():
    draws = FlightSampler(3)
    chunks = [flights(SPEC, 16 * i, 16 * i + 16) for i in range(MAX_CACHED)]
    first = draws.inputs(chunks[0])
    for chunk in chunks:
        draws.inputs(chunk)
    assert len(draws._cache) == MAX_CACHED
    assert same(draws.inputs(chunks[0]), first)


def test_another_correlation_time_filters_the_same_normals():
    """Processes of times 0.3 and 0.25 s driven by one white noise have the correlation 2 sqrt(ab) / (a + b), nearly 1."""
    draws = FlightSampler(3)
    columns = []
    for time in (0.3, 0.25):
        injection = Injection(angular_sigma=(1.0, 0.0, 0.0), angular_time=(time, 1.0, 1.0))
        spec = replace(SPEC, duration=8.0, air=replace(CALM, window=None, injection=injection))
        columns.append(draws.inputs(flights(spec, 0, 32)).disturbances[:, :, 9].ravel())
    expected = 2.0 * np.sqrt(0.3 * 0.25) / (0.3 + 0.25)
    # 32 flights of 8 s hold some 32 * 8 / (2 * 0.3) = 430 independent values.
    assert np.corrcoef(columns)[0, 1] == pytest.approx(expected, abs=4.0 * (1.0 - expected**2) / np.sqrt(430))
