"""Demands of failure modes beside the traces and statuses of the flights."""

from dataclasses import replace
from math import acos, cos, radians, sqrt

import numpy as np
import pytest

from objectives.failure_modes import LARGEST, FailureMode, failure_demands
from objectives.metrics.columns import unpack
from objectives.own_meters import metering
from objectives.system import System
from plant.backends.flyer import result_parts
from plant.loop import LARGEST_STATE
from plant.quadrotor.closed_loop import Limits
from plant.records import rows
from plant.status import Status
from tests.plant import loops
from tests.plant.model.plants import CASCADE_GAINS, cascade
from tests.plant.model.test_plant_flights import SPEC as PLANT_SPEC

COUNT = 48


def demanded(system, results, duration):
    meters, status, end = result_parts(results)
    return failure_demands(
        system.failure_modes, unpack(system.loop.Meters, meters), status, 1.0 - end / duration
    ), status


@pytest.fixture(scope="module")
def quadrotor():
    made = System(loops.VEHICLE, loops.loop().cascade, loops.NOMINAL, loops.LIMITS, loops.TIMING)
    return metering(made, [mode.metric for mode in made.failure_modes if mode.metric])


def flown(system):
    inputs = system.sample(loops.spec(duration=0.4), 7, "search", range(COUNT))
    return inputs, system.flyer(1).fly(loops.gains()[None], system.nominal, inputs)[0]


@pytest.mark.slow
def test_demands_are_largest_errors_and_tilts_over_their_limits(quadrotor):
    inputs, results = flown(quadrotor)
    trace = quadrotor.flyer(1).trace(loops.gains(), quadrotor.nominal, inputs)
    position = trace[..., rows(quadrotor.loop.Flight, "body.position")]
    w, x, y, z = np.moveaxis(trace[..., rows(quadrotor.loop.Flight, "body.attitude")], -1, 0)
    error = np.abs(position - inputs.references[:, :3]).max(axis=(1, 2))
    tilt = np.arccos(1.0 - 2.0 * (x * x + y * y)).max(axis=1)
    demands, status = demanded(quadrotor, results, 0.4)
    assert not status.any()
    # A trace begins one instant later than the meters and ends one later.
    assert demands[:, 0] == pytest.approx(error / 5.0, abs=0.01)
    assert demands[:, 1] == pytest.approx(tilt / radians(80.0), rel=0.02, abs=2e-3)
    assert demands[:, 2] == pytest.approx(5.0 * demands[:, 0] / sqrt(LARGEST_STATE))


@pytest.mark.parametrize(
    ("limits", "mode", "status"),
    [
        (Limits(0.9, cos(radians(80.0))), 0, Status.LOST),
        (Limits(5.0, cos(radians(5.0))), 1, Status.TILTED),
    ],
)
def test_a_lost_flight_fails_by_the_mode_of_its_status_alone_and_more_the_earlier(quadrotor, limits, mode, status):
    system = replace(quadrotor, limits=limits)
    _, results = flown(system)
    demands, ended = demanded(system, results, 0.4)
    lost = ended == status.code
    assert lost.any()
    assert np.array_equal(demands[:, mode] >= 1.0, lost)
    assert (np.delete(demands, mode, axis=1) < 1.0).all()
    left = 1.0 - results[lost, -1] / 0.4
    assert np.array_equal(np.argsort(demands[lost, mode], kind="stable"), np.argsort(left, kind="stable"))
    assert acos(limits.cosine_tilt) > 0.0


def test_modes_of_one_status_share_it_by_the_largest_demand():
    modes = [FailureMode(name, Status.LOST, lambda meters, i=i: meters[i]) for i, name in enumerate("ab")]
    meters, lost = np.array([[0.9, 0.99, 1.5], [0.99, 0.2, np.nan]]), Status.LOST.code
    demands = failure_demands(modes, meters, np.array([lost, lost, 0]), np.array([0.5, 0.25, 0.0]))
    assert demands.tolist() == [[0.9, 1.5], [1.25, 0.2], [LARGEST, 0.0]]


def test_a_plant_fails_by_its_channels():
    system = cascade()
    inputs = system.sample(PLANT_SPEC, 7, "search", range(COUNT))
    results = system.flyer(1).fly(CASCADE_GAINS[None], system.nominal, inputs)[0]
    demands, _ = demanded(system, results, PLANT_SPEC.duration)
    limited = [channel for channel in system.plan.channels if np.isfinite(channel.limit)]
    assert [mode.name for mode in system.failure_modes] == [*(channel.name for channel in limited), "diverged"]
    assert (demands[:, 0] > 0.0).all()
