"""The Gaussian space of a flight: flights from vectors of normals beside those of NumPy's own generators."""

from functools import cache

import numpy as np
import pytest
from scipy.stats import ks_2samp, kstest

from plant.air.spec import AirSpec
from plant.quadrotor.airframes.uncertainty import Uncertainty
from plant.quadrotor.scenarios import ScenarioSpec, Spread, draw_scenarios
from plant.quadrotor.sensors import SensorSpec
from plant.references.steps import Steps
from plant.seeds import source_of
from tests.plant import loops
from tests.plant.model.plants import cascade
from tests.plant.model.test_plant_flights import SPEC as PLANT_SPEC
from tuner.extensions.tails.normals import NormalGenerator, NormalSpace

FLIGHTS = 400
GUSTY = ScenarioSpec(
    "gusty",
    0.4,
    Steps(x=1.0, time=0.1),
    AirSpec(intensity="moderate", mean_wind=True, angular_rates=True),
    SensorSpec(attitude_bias=0.01),
    Spread(mass=0.1, lag=0.1),
    uncertainty=Uncertainty(("inertia.z", "torque_ratio"), (0.3, 0.5), ((1.0, 0.0), (0.0, 1.0))),
)


def drawn(source, count, spec=GUSTY):
    return draw_scenarios(spec, loops.VEHICLE, loops.TIMING, source, range(count))


@cache
def space():
    return NormalSpace.of(lambda source: drawn(source, 1))


def vectors(count, seed=1):
    return np.random.default_rng(seed).standard_normal((count, space().dimension))


def flown(inputs):
    return loops.flyer(threads=1).fly(loops.gains()[None], loops.NOMINAL, inputs)[0]


def test_every_number_of_a_flight_has_its_place():
    steps = 100
    assert space().parts == {
        "vehicle": slice(0, 8),
        "air": slice(8, 9 + 8 * steps),
        "sensors": slice(9 + 8 * steps, 21 + 20 * steps),
    }
    assert space().paths["air/1"] == slice(9 + 5 * steps, 9 + 8 * steps)
    assert space().dimension == 21 + 20 * steps


def test_the_same_vector_gives_the_same_flight_whatever_flies_beside_it():
    all_vectors = vectors(5)
    alone, among = (drawn(space().source(given), len(given)) for given in (all_vectors[3:4], all_vectors))
    for name in ("dynamics", "starts", "disturbances", "noises"):
        assert np.array_equal(getattr(alone, name)[..., 0], getattr(among, name)[..., 3])


@pytest.mark.parametrize(
    ("part", "changed"),
    [("vehicle", {"dynamics", "starts"}), ("air", {"disturbances", "starts"}), ("sensors", {"noises"})],
)
def test_a_part_of_the_vector_moves_its_part_of_the_flight_alone(part, changed):
    first, second = vectors(1), vectors(1)
    second[:, space().parts[part]] += 0.1
    before, after = (drawn(space().source(given), 1) for given in (first, second))
    names = ("dynamics", "starts", "disturbances", "noises")
    assert {name for name in names if not np.array_equal(getattr(before, name), getattr(after, name))} == changed


def same(first: np.ndarray, second: np.ndarray) -> float:
    """Return the p value that two samples have one distribution (Kolmogorov and Smirnov)."""
    _, value = ks_2samp(first, second)
    return float(np.asarray(value))


def test_independent_normals_give_flights_of_the_same_distribution():
    there, here = flown(drawn(source_of(5, "there"), FLIGHTS)), flown(drawn(space().source(vectors(FLIGHTS)), FLIGHTS))
    moving = [row for row in range(there.shape[1]) if np.ptp(there[:, row]) > 0.0]
    worst = min(same(there[:, row], here[:, row]) for row in moving)
    assert len(moving) > 40
    assert worst > 1e-3 / len(moving)


def test_a_smaller_spread_would_be_seen():
    calm = vectors(FLIGHTS)
    calm[:, space().parts["air"]] *= 0.7
    there, here = flown(drawn(source_of(5, "there"), FLIGHTS)), flown(drawn(space().source(calm), FLIGHTS))
    assert min(same(there[:, row], here[:, row]) for row in range(66)) < 1e-6


@pytest.mark.slow
def test_vehicles_drawn_again_remain_a_function_of_the_vector_with_the_same_distribution():
    impossible = Uncertainty(("inertia.z",), (0.8,), ((1.0,),))
    spec = ScenarioSpec("wide", 0.02, uncertainty=impossible)
    source = lambda given: NormalSpace.of(lambda each: drawn(each, 1, spec)).source(given)  # noqa: E731
    normals = np.random.default_rng(3).standard_normal((600, 7 + 12 * 6))
    steps = [impossible.step(loops.VEHICLE, _after_six(source(normals)("vehicle", i))) for i in range(600)]
    expected = [impossible.step(loops.VEHICLE, source_of(1, "wide")("vehicle", i)) for i in range(600)]
    again = [impossible.step(loops.VEHICLE, _after_six(source(normals)("vehicle", i))) for i in range(20)]
    assert np.array_equal(again, steps[:20])
    assert np.mean(normals[:, 6] * 0.8 > np.max(steps)) > 0.05
    assert same(np.ravel(steps), np.ravel(expected)) > 1e-3


def _after_six(generator):
    generator.uniform(size=6)
    return generator


def test_a_plants_flight_has_a_space_too():
    system = cascade()
    space = NormalSpace.of(lambda source: system.draw(PLANT_SPEC, source, [0]))
    steps = PLANT_SPEC.steps(system.timing)
    assert {part: place.stop - place.start for part, place in space.parts.items()} == {
        "plant": len(system.plant.Parameters._fields),
        "disturbance/push": steps,
        "sensor/angle": steps + 1,
        "sensor/speed": steps + 1,
    }
    given = np.random.default_rng(2).standard_normal((300, space.dimension))
    here = system.draw(PLANT_SPEC, space.source(given), range(300))
    there = system.sample(PLANT_SPEC, 7, "search", range(300))
    for name in ("dynamics", "disturbances", "noises"):
        # One instant of each flight: instants of a flight are not independent.
        pair = [np.moveaxis(getattr(each, name), -1, 1) for each in (here, there)]
        a, b = (each.reshape(-1, *each.shape[2:])[:300].reshape(300, -1)[:, -1] for each in pair)
        assert np.ptp(a) == 0.0 or same(a, b) > 1e-3


def test_uniform_numbers_are_uniform():
    generator = NormalGenerator(lambda path, place, shape: np.random.default_rng(1).standard_normal(shape), "x")
    assert kstest(np.ravel(generator.uniform(2.0, 5.0, 4000)), "uniform", (2.0, 3.0)).pvalue > 1e-3
    assert isinstance(generator.standard_normal(), float)
