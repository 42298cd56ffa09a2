"""The cuda backend in Numba's simulator, which runs the kernel's Python thread by thread: no card and no compiler is needed."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plant.backends.flyer import result_parts
from plant.backends.lane_layout import LANES, result_rows
from plant.backends.stepping import Inputs, fly_steps, unchanged
from plant.records import flatten, pack
from plant.status import Status
from tests.plant.loops import LIMITS, NOMINAL, TIMING, flyer, inputs, loop
from tests.tuner.extensions.cuda.flights import CASES, SCENARIOS, SHORT, assert_alike, batch, rows

ROOT = Path(__file__).parents[4]
# The simulator takes 5 s of processor time.
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    file = tmp_path_factory.mktemp("cuda") / "flights.npz"
    world = os.environ | {"NUMBA_ENABLE_CUDASIM": "1", "TUNER_CACHE_DIR": str(file.parent / "kernels")}
    command = [sys.executable, "-m", "tests.tuner.extensions.cuda.simulated", str(file)]
    done = subprocess.run(command, cwd=ROOT, env=world, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-3000:]
    with np.load(file) as content:
        return dict(content)


def plain(pair, row, scenarios, index):
    """Result of one flight in plain Python."""
    block, lane = divmod(index, LANES)
    flat = Inputs(
        scenarios.dynamics[block, :, lane].tolist(),
        scenarios.starts[block, :, lane].tolist(),
        scenarios.disturbances[block, :, :, lane],
        scenarios.noises[block, :, :, lane],
        scenarios.references,
    )
    record = pack(loop(*pair).cascade.Gains, row.tolist())
    flight = fly_steps(loop(*pair), unchanged, record, NOMINAL, flat, scenarios.targets, LIMITS, TIMING)
    return np.array(flatten(flight))[result_rows(loop(*pair))]


@pytest.mark.parametrize(("precision", "pair"), CASES)
def test_the_kernel_flies_what_plain_python_flies(found, precision, pair):
    results = found["/".join((precision, *pair))]
    assert results.dtype == np.float64
    for candidate, scenario in ((0, 0), (1, 2)):
        wanted = plain(pair, rows(*pair)[candidate], batch(), scenario)
        assert_alike(results[candidate, scenario], wanted, precision, SHORT)


def test_single_precision_is_single_and_double_is_double(found):
    single, double = (found[f"{precision}/ladrc/hybrid"] for precision in ("float32", "float64"))
    assert np.array_equal(single, single.astype(np.float32))
    assert np.abs(single - double).max(axis=None) > 1e-8


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_every_flight_lands_in_its_place_as_in_the_lanes(found, precision):
    wanted = flyer().fly(rows(), NOMINAL, batch())
    assert_alike(found[f"{precision}/ladrc/hybrid"], wanted, precision, SHORT)


def test_a_flight_does_not_depend_on_its_launch(found):
    # At most 4 flights a launch: candidates with 3 scenarios fly one after the other.
    assert found["on_flights_done"].tolist() == [SCENARIOS] * 3
    assert np.array_equal(found["one"][0], found["launches"][1, :2])
    assert_alike(found["launches"], flyer().fly(rows(count=3), NOMINAL, batch(0.2)), "float64", 0.2)


def test_rows_of_air_and_noise_that_are_there_or_left_out(found):
    scenarios = replace(batch(), disturbances=found["air"], noises=batch().noises[:, :, :0])
    assert_alike(found["full"], flyer().fly(rows(count=1), NOMINAL, scenarios), "float64", SHORT)


def test_a_flight_whose_air_is_not_a_number_ends_alone(found):
    calm, broken = found["float64/ladrc/hybrid"], found["broken"]
    _, status, end_time = result_parts(broken)
    assert status.tolist() == [[0, Status.NON_FINITE.code, 0]]
    assert end_time[:, 1] == pytest.approx(51 * TIMING.control_period, abs=1e-12)
    assert np.array_equal(broken[0, [0, 2]], calm[0, [0, 2]])
    assert np.isfinite(broken).all()


def test_the_engine_flies_parts_together_and_gives_them_back_one_by_one(found):
    # A card of 5 flights at once: the first part's 6 fill it, the others' 9 are flown when the last has come; LARGEST_LAUNCH
    # is 4, so each candidate's 3 flights are a launch.
    assert found["stream_launches"].tolist() == [3] * 5
    wanted = flyer().fly(rows(count=5), NOMINAL, inputs(range(1, 4), duration=0.2))
    assert_alike(found["stream"], wanted, "float64", 0.2)
