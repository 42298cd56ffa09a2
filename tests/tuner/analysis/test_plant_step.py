"""The plant step: fewest steps that the rotors allow, and its error against flights with far shorter steps."""

import json
import shutil
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plant.errors import StoreError
from plant.own_code import run_own_code
from plant.quadrotor.airframes import load
from plant.quadrotor.scenarios import sample_scenarios
from tests.plant.model.plants import FILES
from tests.tuner.conftest import QUICKSTART, SMALL
from tuner.analysis.plant_step import (
    FLIGHTS,
    LARGEST,
    LARGEST_SHARE,
    RICHARDSON,
    STREAM,
    estimated_plant_step,
    mean_errors,
    plant_step_of,
    plant_step_warnings,
)
from tuner.api.studies import make_study
from tuner.documents.parts import PlantStep
from tuner.experiments.again.resume import recorded_study
from tuner.experiments.tuning.problem import problem_of
from tuner.gains.ranges import usual_timing
from tuner.study.build import load_study

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
    resolved: dict[str, Any] = usual.resolved()
    assert resolved["controller"]["plant_step"] == 0.004


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
    floor, unseen = np.full(3, 1e-7), np.zeros(3)
    errors = mean_errors(coarse, fine, counted, 100, floor, unseen)
    assert errors.standard[0] == pytest.approx(
        RICHARDSON * 0.01 / (fine[0, 0][counted[0]].std(ddof=1) / 10.0), rel=1e-9
    )
    assert np.isnan(errors.standard[1]) and errors.standard[2] == 0.0
    assert np.isnan(errors.relative[[0, 2]]).all()
    counted[:] = False
    assert np.isnan(mean_errors(coarse, fine, counted, 100, floor, unseen)).all()


def test_where_flights_do_not_differ_the_error_is_a_share_of_their_value():
    """Of a value of 3, of a time that is a period of 0.04 s later, of one that is two, of what has decayed to rounding, of 0."""
    fine = np.array([3.0, 2.0, 2.0, 1e-12, 0.0])[None, :, None] * np.ones(8)
    coarse = fine + np.array([-0.06, 0.037, 0.08, 1e-12, 0.0])[None, :, None]
    counted, floor, unseen = np.ones((1, 8), dtype=bool), np.full(5, 1e-7), np.array([0.0, 0.04, 0.04, 0.0, 0.0])
    errors = mean_errors(coarse, fine, counted, 100, floor, unseen)
    assert np.isnan(errors.standard).all()
    wanted = [RICHARDSON * 0.02, 0.0, (RICHARDSON * 0.08 - 0.04) / 2.0, RICHARDSON * 1e-5, np.nan]
    assert errors.relative == pytest.approx(wanted, rel=1e-9, nan_ok=True)
    counted[:, 1:] = False
    one = mean_errors(coarse + np.arange(8.0), fine + np.arange(8.0), counted, 100, floor, unseen)
    assert np.isnan(one.standard).all() and one.relative == pytest.approx(wanted, rel=1e-9, nan_ok=True)


def sway(**plant):
    """Two masses and a spring of 50 rad/s at 40 ms, in which nothing is random."""
    tables = {
        "title": "Sway",
        "seed": 1,
        "plant": {"control_period": 0.04, "parameters": {"second_frequency": 1.0}, **plant},
        "actuator": [{"name": "force", "low": -1e3, "high": 1e3}],
        "channel": [{"name": "place", "law": "pid", "output": "place", "to": "force", "lost_beyond": 1e3}],
        "gains": {
            "place.kp": {"low": 1.0, "high": 8.0, "default": 4.0},
            "place.ki": 0.0,
            "place.kd": 8.0,
            "place.t_f": 0.0,
        },
        "scenario": [
            {
                "name": "step",
                "duration": 4.0,
                "search": 4,
                "held_out": 8,
                "reference": {"place": {"kind": "step", "size": 1.0}},
            }
        ],
        "objective": [{"metric": "iae.place"}, {"metric": "travel"}],
    }
    return make_study(tables, "sway", plant=run_own_code(FILES["modal"]).names)


@pytest.mark.slow
def test_flights_that_do_not_differ_and_margins_tell_a_plant_step_that_is_too_long():
    """Without anything random the error was 0, and the remedy that was named left a tenth of it."""
    long = sway(plant_step=0.04)
    errors = estimated_plant_step(problem_of(long, 1, None), long, long.default_row[None])
    assert errors.error is None and (errors.relative_metric, errors.margin) == ("travel", "phase_margin")
    # Ms alone, no margin with the largest error, is 1.57 in place of 2.67.
    assert (errors.relative_error or 0.0) > 0.1 and (errors.margin_error or 0.0) > 1.0 - 1.572 / 2.674
    warnings = plant_step_warnings(errors, long.plant_step_key)
    assert [text.split(" puts ")[1].split(" off ")[0] for text in warnings] == [
        "travel",
        "phase_margin",
    ]
    advised = float(warnings[0].split("plant.plant_step = ")[1].rstrip("."))
    for short in (sway(plant_step=advised), sway()):
        mended = estimated_plant_step(problem_of(short, 1, None), short, short.default_row[None])
        assert max(mended.relative_error or 1.0, mended.margin_error or 1.0) < LARGEST_SHARE
        assert not plant_step_warnings(mended) and mended.advised is None


def test_a_loop_that_is_stable_in_its_steps_alone_is_warned_of():
    long = sway(plant_step=0.04)
    gains = long.default_row.copy()
    gains[2] = 20.0
    alone = plant_step_of(long, gains[None])
    assert (alone.margin, alone.margin_error) == ("stability", 1.0)
    assert alone.words.endswith("error up to 100 % of a margin (stability)")


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
    found = PlantStep(
        step=0.004, steps=1, fixed=True, flights=16, error=0.25, metric="travel", ended_otherwise=3, advised=0.002
    )
    off, otherwise = plant_step_warnings(found)
    assert "the mean of travel off by 0.25 standard errors" in off and "write controller.plant_step = 0.002." in off
    assert otherwise.startswith("3 of 16 flights end otherwise")
    assert "write plant.plant_step = 0.002." in plant_step_warnings(found, "plant.plant_step")[0]


def test_a_run_of_an_earlier_version_is_read_with_the_step_that_it_flew(small_run, tmp_path):
    folder = tmp_path / "old"
    shutil.copytree(small_run[1], folder)
    record = json.loads((folder / "run.json").read_text())
    flown = load_study(folder / record["study"], {"controller.plant_step": 0.001}).digest()
    assert record["version"] == 5 and record["digest"] != flown
    (folder / "run.json").write_text(json.dumps(record | {"version": 2, "digest": flown}))
    assert recorded_study(folder)[0].system.timing.plant_step == 0.001
    (folder / "run.json").write_text(json.dumps(record | {"digest": flown}))
    with pytest.raises(StoreError, match="is not what the run began with"):
        recorded_study(folder)
