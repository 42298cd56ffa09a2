"""The plant step: fewest steps that the rotors allow, and its error against flights with far shorter steps."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from plant.airframes import load
from plant.errors import StoreError
from plant.scenarios import sample_scenarios
from tests.tuner.conftest import QUICKSTART, SMALL
from tuner.analysis.plant_step import (
    FLIGHTS,
    LARGEST,
    RICHARDSON,
    STREAM,
    estimated_plant_step,
    mean_errors,
    plant_step_of,
    plant_step_warnings,
)
from tuner.documents.parts import PlantStep
from tuner.experiments.again.resume import recorded_study
from tuner.experiments.tuning.problem import problem_of
from tuner.gains.ranges import usual_timing
from tuner.study import load_study

FAST_ROTORS = {"airframe.name": "hummingbird-rotorpy", "scenario.0.duration": 3.0, "margin": []}


@pytest.mark.parametrize("period", [1e-5, 0.001, 0.002, 0.004, 0.005, 0.01, 0.02, 0.03, 0.1])
@pytest.mark.parametrize("airframe", ["hummingbird", "hummingbird-rotorpy", "iris"])
def test_steps_are_the_fewest_that_half_the_shortest_lag_allows(airframe, period):
    vehicle = load(airframe).vehicle
    timing = usual_timing(period, load(airframe))
    fewest = next(n for n in range(1, 1000) if period / n <= 0.5 * min(vehicle.lag_up, vehicle.lag_down) * (1.0 + 1e-9))
    assert timing.steps == fewest and timing.control_period == period
    assert timing.plant_step * fewest == pytest.approx(period, rel=1e-15)


def test_a_study_may_fix_the_step_and_the_digest_tells():
    usual, fixed, same = (
        load_study(QUICKSTART, changes)
        for changes in ({}, {"controller.plant_step": 0.001}, {"controller.plant_step": 0.004})
    )
    assert [study.system.timing.plant_step for study in (usual, fixed)] == [0.004, 0.001]
    assert [plant_step_of(study).fixed for study in (usual, fixed)] == [False, True]
    assert usual.digest() == same.digest() != fixed.digest()
    assert usual.resolved()["controller"]["plant_step"] == 0.004


def test_the_mean_is_off_by_its_change_over_its_standard_error():
    draw = np.random.default_rng(5)
    fine = draw.standard_normal((2, 3, 40))
    coarse = fine + np.array([0.01, -0.02, 0.0])[:, None] * np.array([1.0, 0.5])[:, None, None]
    coarse[0, 2, 7] = 1e6
    counted = np.ones((2, 40), dtype=bool)
    counted[0, 7] = False
    # Flights of one scenario without noise are one flight, but for rounding.
    fine[:, 1] = 3.0
    fine[:, 1, ::2] = np.nextafter(3.0, 4.0)
    errors = mean_errors(coarse, fine, counted, 100)
    assert errors[0] == pytest.approx(RICHARDSON * 0.01 / (fine[0, 0][counted[0]].std(ddof=1) / 10.0), rel=1e-9)
    assert errors[1] == 0.0 and errors[2] == 0.0
    counted[:] = False
    assert np.all(mean_errors(coarse, fine, counted, 100) == 0.0)


def test_the_estimate_is_the_error_against_steps_sixteen_times_as_short():
    """At 0.8 rotor lags, more than a study may ask for, the error stands far above rounding."""
    study = load_study(QUICKSTART, FAST_ROTORS)
    timing = study.system.timing._replace(plant_step=0.004)
    study = replace(study, system=replace(study.system, timing=timing))
    problem, gains = problem_of(study, 1, None), study.default_row[None]
    spec, held_out = study.scenarios[0].spec, study.scenarios[0].held_out
    inputs = sample_scenarios(spec, study.system.vehicle, timing, study.seed, STREAM, range(FLIGHTS))
    coarse, exact = (
        problem.score(problem.flyer.at(used).fly(gains, study.system.nominal, inputs), spec)[0]
        for used in (timing, timing._replace(plant_step=0.00025))
    )
    off, spread = np.abs(np.mean(coarse - exact, axis=-1))[0], np.std(exact, axis=-1, ddof=1)[0]
    true = off[spread > 0.0] / (spread[spread > 0.0] / held_out**0.5)
    found = estimated_plant_step(problem, study, gains)
    assert found.error == pytest.approx(true.max(), rel=0.1)
    assert found.metric in {str(quantity.metric) for quantity in problem.quantities} and found.ended_otherwise == 0


def test_the_quickstart_keeps_the_share_and_says_so():
    study = load_study(QUICKSTART, SMALL)
    found = estimated_plant_step(problem_of(study, 1, None), study, study.default_row[None])
    assert (found.steps, found.step, found.flights) == (1, 0.004, FLIGHTS) and not plant_step_warnings(found)
    assert found.error is not None and 0.0 < found.error < LARGEST
    assert found.words.startswith("1 step of 4 ms a control period; error up to ")


def test_too_long_a_step_is_warned_of():
    found = PlantStep(step=0.004, steps=1, fixed=True, flights=16, error=0.25, metric="travel", ended_otherwise=3)
    off, otherwise = plant_step_warnings(found)
    assert (
        "the mean of travel off by 0.25 standard errors" in off and "controller.plant_step, for instance 0.002" in off
    )
    assert otherwise.startswith("3 of 16 flights end otherwise")
    assert "plant.plant_step, for instance 0.002" in plant_step_warnings(found, "plant.plant_step")[0]


def test_a_run_of_an_earlier_version_is_read_with_the_step_that_it_flew(small_run, tmp_path):
    folder = tmp_path / "old"
    shutil.copytree(small_run[1], folder)
    record = json.loads((folder / "run.json").read_text())
    flown = load_study(folder / record["study"], {"controller.plant_step": 0.001}).digest()
    assert record["version"] == 3 and record["digest"] != flown
    (folder / "run.json").write_text(json.dumps(record | {"version": 2, "digest": flown}))
    assert recorded_study(folder)[0].system.timing.plant_step == 0.001
    (folder / "run.json").write_text(json.dumps(record | {"digest": flown}))
    with pytest.raises(StoreError, match="is not what the run began with"):
        recorded_study(folder)
