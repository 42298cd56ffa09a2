"""Events of flights: what they are of, what is refused, and their limit functions on any number of threads."""

from functools import cache
from math import radians

import numpy as np
import pytest

from objectives.problem import score_flights
from plant.errors import InputError
from tests.plant.model.plants import CASCADE_GAINS, cascade
from tests.plant.model.test_plant_flights import SPEC as PLANT_SPEC
from tests.tuner.conftest import QUICKSTART
from tests.tuner.extensions.fmu import test_fmu_flights as fmus
from tuner.extensions.tails.events import read_event
from tuner.extensions.tails.flight_limit import FlightLimit, inputs_of
from tuner.study.build import load_study


@cache
def study():
    return load_study(QUICKSTART, {"scenario.0.duration": 1.0})


def event(text):
    return read_event(text, study().system, study().scenarios[0].spec)


def limit_of(text, threads=1):
    return FlightLimit(event(text), study().scenarios[0].spec, study().default_row, threads, lambda _: None)


def normals(limit, count=40):
    return np.random.default_rng(1).standard_normal((count, limit.dimension))


@pytest.mark.parametrize(
    ("text", "limit"),
    [
        ("peak.position > 3", 3.0),
        ("peak.position>=3e0 m", 3.0),
        ("peak.attitude > 20 deg", radians(20.0)),
        ("peak.attitude > 0.3 rad", 0.3),
        ("saturation > 0.2", 0.2),
    ],
)
def test_a_limit_is_in_the_unit_of_its_metric(text, limit):
    assert event(text).limit == pytest.approx(limit)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("peak.position", "write METRIC > NUMBER"),
        ("peak.position < 3", "write METRIC > NUMBER"),
        ("peak.posi > 3", "did you mean 'peak.position'"),
        ("peak.position > 5", "at most 5: take a smaller limit, or failure"),
        ("saturation > 1", "at most 1:"),
        ("peak.position > -1", "a number above 0"),
        ("peak.position > nan", "a number above 0"),
        ("peak.position > 3 cm", "the unit of peak.position is m"),
        ("failure > 0.5", "0 or 1, which does not show how near a flight came; write failure alone"),
        ("overshoot.roll > 5", "needs a step"),
        ("recovery.x > 0.5 min", "the unit of recovery.x is s"),
    ],
)
def test_what_cannot_be_an_event_is_told_in_a_sentence(text, sentence):
    with pytest.raises(InputError, match=sentence.replace(".", r"\.")):
        event(text)


def test_the_demand_of_a_metric_is_its_value_over_the_limit():
    limit, spec = limit_of("peak.position > 2"), study().scenarios[0].spec
    system = limit_of("peak.position > 2").flyer
    given = normals(limit)
    inputs = inputs_of(study().system, spec, limit.space, given)
    results = system.fly(study().default_row[None], study().system.nominal, inputs)[0]
    metric = event("peak.position > 2").metric
    assert metric is not None
    scores, _ = score_flights(study().system, [metric], results, spec, study().system.targets(spec))
    assert np.array_equal(limit.values(given)[:, 0], scores[0] / 2.0)


@pytest.mark.parametrize("text", ["peak.position > 2", "failure"])
def test_flights_have_the_same_bits_on_any_number_of_threads_and_beside_any_others(text):
    one, three = limit_of(text), limit_of(text, threads=3)
    given = normals(one, 50)
    wanted = one.values(given)
    assert np.array_equal(three.values(given), wanted)
    assert np.array_equal(one.values(given[17:20]), wanted[17:20])


def test_a_lost_flight_is_beyond_every_limit():
    tight = load_study(QUICKSTART, {"scenario.0.duration": 1.0, "limits.position": 1.05})
    spec = tight.scenarios[0].spec
    found = read_event("peak.position > 1.04", tight.system, spec)
    limit = FlightLimit(found, spec, tight.default_row, 1, lambda _: None)
    loss = FlightLimit(read_event("failure", tight.system, spec), spec, tight.default_row, 1, lambda _: None)
    given = normals(limit, 200)
    lost = loss.values(given).max(axis=1) >= 1.0
    assert 0 < lost.sum() < 200
    assert (limit.values(given)[lost] >= 1.0).all()


def test_plants_and_fmus_have_limit_functions_too():
    system = cascade()
    for text, modes in (("peak.angle > 1", 1), ("failure", len(system.failure_modes))):
        found = read_event(text, system, PLANT_SPEC)
        limit = FlightLimit(found, PLANT_SPEC, CASCADE_GAINS, 2, lambda _: None)
        assert limit.values(normals(limit, 3)).shape == (3, modes)


@pytest.mark.slow
@pytest.mark.parametrize("text", ["peak.angle > 1.5", pytest.param("failure", marks=pytest.mark.slow)])
def test_an_fmu_demands_what_the_same_plant_in_python_does(text):
    native, fmu = (
        FlightLimit(read_event(text, system, fmus.SPEC), fmus.SPEC, fmus.GAINS[0], 2, lambda _: None)
        for system in (fmus.native(), fmus.fmu(2))
    )
    drawn = normals(native, 4)
    same = np.zeros((4, fmu.dimension))
    for part, place in native.space.parts.items():
        if part != "plant":
            same[:, fmu.space.parts[part]] = drawn[:, place]
    # An FMU has its parameters in an order of its own.
    names = [limit.names_of_draws["plant"] for limit in (native, fmu)]
    for number, name in enumerate(names[0]):
        same[:, fmu.space.parts["plant"].start + names[1].index(name)] = drawn[
            :, native.space.parts["plant"].start + number
        ]
    assert fmu.values(same) == pytest.approx(native.values(drawn), rel=1e-4)
