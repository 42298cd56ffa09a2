"""Accumulators that metrics bring along, in flights of a quadrotor and of a plant, beside meters that the tool has."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from objectives.decisions import DecisionSpace
from objectives.memory import scenario_key
from objectives.metrics import Accumulator, Metric
from objectives.metrics.address import MetricAddress, parse
from objectives.own_meters import metering
from objectives.problem import FlightBatch, Objective, Problem
from objectives.risk import Risk
from objectives.system import System
from plant.backends.flyer import Flyer
from plant.errors import InputError
from plant.loop import Timing
from plant.own_code import run_own_code
from plant.primitives import absolute, maximum
from plant.records import paths
from tests.plant.loops import LIMITS, NOMINAL, TIMING, VEHICLE, gains, inputs, loop, spec
from tests.plant.own_files import SWAY
from tuner.api.studies import load_study
from tuner.extensions.cluster.brief import brief_of, system_of
from tuner.study.plant_study import PlantStudy

FLIGHTS = 3


class Sum(NamedTuple):
    total: float


def start_sum(sample, target):  # noqa: ARG001
    return Sum(0.0)


def add_error(kept, sample, target, t, h):  # noqa: ARG001
    return Sum(kept.total + h * absolute(sample.reference - sample.actual))


def add_command(kept, sample, targets, h):  # noqa: ARG001
    return Sum(maximum(kept.total, sample.command.r1))


def metric(name, scope, update):
    """A metric that is what its accumulator holds."""
    return Metric(
        name,
        name,
        "1",
        scope,
        name,
        lambda view: view.accumulated.total,
        lambda view: 1e3,
        accumulator=Accumulator(Sum, start_sum, update),
    )


ERROR, COMMAND = metric("own_iae", "axis", add_error), metric("own_peak", "flight", add_command)
ASKED = (
    MetricAddress("own_iae.position", ERROR, ("x", "y", "z")),
    MetricAddress("own_peak", COMMAND, ()),
    MetricAddress("sway.x", run_own_code(SWAY).names["METRIC"], ("x",)),
)
SYSTEM = System(VEHICLE, loop().cascade, NOMINAL, LIMITS, TIMING)
# All quadrotors here fly one kernel, which takes 15 s to compile.
METERED = metering(SYSTEM, ASKED)
BATCH = FlightBatch(spec(), "search", FLIGHTS)


def scores(system, addresses, batch, row):
    """Return the scores (metrics, flights) of one gains row."""
    objectives = tuple(Objective(address, Risk("mean")) for address in addresses)
    problem = Problem(system, DecisionSpace((), (), tuple(row.tolist())), objectives, (), 7, 1)
    return problem.evaluate_gains(row[None], (batch,)).scores[0]


@pytest.mark.slow
def test_a_quadrotor_and_a_plant_hold_what_the_bundled_meters_hold():
    addresses = (*ASKED[:2], parse("iae.position"), parse("command_peak"))
    own, peak, bundled, highest = scores(METERED, addresses, BATCH, gains())
    assert np.array_equal(own, bundled)
    assert (peak > 1.0).all() and (peak <= highest).all()
    study = load_study("dc_motor", kind=PlantStudy)
    turned = (MetricAddress("own_iae.angle", ERROR, ("angle",)), parse("iae.angle", study.system.axes))
    own, bundled = scores(
        study.system, turned, FlightBatch(study.scenarios[0].spec, "search", FLIGHTS), study.default_row
    )
    assert np.array_equal(own, bundled) and (own > 0.0).all()


@pytest.mark.slow
def test_the_way_that_an_axis_goes_is_that_of_its_trajectory():
    (found,) = scores(METERED, ASKED[2:], BATCH, gains())
    row = paths(loop().Flight).index("body.position.x")
    trace = Flyer(loop(), LIMITS, TIMING, 1).trace(gains(), NOMINAL, inputs(range(FLIGHTS)), 1, [row])
    assert found == pytest.approx(np.abs(np.diff(trace[..., 0], axis=1)).sum(axis=1), rel=1e-12)


@pytest.mark.slow
def test_flights_without_an_accumulator_are_those_of_before():
    assert metering(SYSTEM, [parse("iae.x")]) is SYSTEM and metering(METERED, ASKED) is METERED
    assert scenario_key(METERED, 7, BATCH) != scenario_key(SYSTEM, 7, BATCH)
    (there,) = scores(METERED, (parse("itae.z"),), BATCH, gains())
    (here,) = scores(SYSTEM, (parse("itae.z"),), BATCH, gains())
    assert np.array_equal(there, here)


def test_workers_take_an_accumulator_by_the_name_of_its_metric(monkeypatch):
    from objectives import metrics

    monkeypatch.setitem(metrics.METRICS, "own_iae", ERROR)
    system = metering(SYSTEM, [parse("own_iae.position")])
    brief = brief_of(system, 7, BATCH)
    assert scenario_key(system_of(brief), 7, BATCH) == brief.key


def test_a_metric_above_what_samples_show_is_refused():
    """Noise counts above 20 Hz; a control period of 25 ms shows less than that."""
    slow = replace(SYSTEM, timing=Timing(0.025, 0.025))
    with pytest.raises(InputError, match="counts above 20 Hz; a control period of 0.025 s shows less than 20 Hz"):
        metering(slow, [parse("noise")])
    assert metering(replace(SYSTEM, timing=Timing(0.024, 0.024)), [parse("noise")]).metered


def add_roll(kept, sample, targets, h):  # noqa: ARG001
    return Sum(kept.total + h * absolute(sample.roll.actual))


@pytest.mark.parametrize(("update", "name"), [(add_roll, "roll"), (add_command, "r1")])
def test_a_plant_refuses_a_metric_that_reads_axes_or_rotors_of_a_quadrotor(update, name):
    address = MetricAddress("own_sum", metric("own_sum", "flight", update), ())
    assert metering(SYSTEM, [address]).loop.Meters
    with pytest.raises(
        InputError, match=f"'own_sum', which reads '{name}' of a flight; this system has .*(angle|voltage)"
    ):
        _ = metering(load_study("dc_motor", kind=PlantStudy).system, [address]).loop


def test_an_error_inside_an_accumulator_of_the_flight_stays_its_own():
    def broken(kept, sample, targets, h):  # noqa: ARG001
        return Sum(kept.no_such_sum)

    address = MetricAddress("own_sum", metric("own_sum", "flight", broken), ())
    with pytest.raises(AttributeError, match="no_such_sum"):
        _ = metering(SYSTEM, [address]).loop
