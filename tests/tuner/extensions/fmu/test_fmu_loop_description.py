"""A worker builds the loop that its parent has from names and numbers, or says why it cannot."""

import pickle
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from objectives.plant_meters import meters_of
from objectives.problem import FlightBatch, Problem
from plant.backends.identity import identity
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.closing import close_plant
from plant.model.plan import Actuator, Channel, WatchedSignal, plan_loop
from plant.quadrotor.scenarios import SEARCH
from tests.plant.own_files import SWAY, forget
from tests.tuner.extensions.fmu.fmus import write_motor
from tuner.api.studies import load_study
from tuner.extensions.fmu.fmu_model import read_fmu
from tuner.extensions.fmu.loop_description import describe_loop, loop_of
from tuner.study.own_code import use

STUDIES = Path(__file__).parents[4] / "studies"
PLAIN = STUDIES / "own_law/pid_plain.py"
TIMING = Timing(0.001, 0.001)


def closed(folder, law):
    plant = read_fmu(write_motor(folder, 2), ["torque"])
    plan = plan_loop(plant, [Channel("angle", law, "angle", "voltage", limit=10.0)], [Actuator("voltage", -12.0, 12.0)])
    return plant, plan, close_plant(plant, plan, meters_of(plan), TIMING.control_period)


def test_the_loop_of_a_brief_is_the_one_it_was_made_from(tmp_path):
    plant, plan, loop = closed(tmp_path, LAWS["pid"])
    description = describe_loop(plant.interface, tmp_path, plan, (), TIMING, 1.0)
    assert identity(loop_of(pickle.loads(pickle.dumps(description)))) == identity(loop)


def test_a_law_of_a_file_is_read_from_it_again(tmp_path):
    own = Path(shutil.copy(PLAIN, tmp_path))
    plant, plan, loop = closed(tmp_path, use(own))
    told = pickle.dumps(describe_loop(plant.interface, tmp_path, plan, (), TIMING, 1.0))
    forget()
    assert identity(loop_of(pickle.loads(told))) == identity(loop)
    forget()
    own.write_text(own.read_text().replace("return demand", "return 2.0 * demand"))
    with pytest.raises(InputError, match="has changed since"):
        loop_of(pickle.loads(told))


def test_a_worker_watches_the_signals_that_its_parent_watches(tmp_path):
    plant, plan, _ = closed(tmp_path, LAWS["pid"])
    watching = plan.watching([WatchedSignal("voltage", "Input", 9.0)])
    description = describe_loop(plant.interface, tmp_path, watching, (), TIMING, 1.0)
    assert loop_of(pickle.loads(pickle.dumps(description))).records.Limits._fields == ("angle", "voltage")


@pytest.mark.slow
def test_accumulators_of_a_metric_of_a_file_run_in_workers_too(tmp_path):
    """Its number is that of the plant in Python; a worker whose loop were without it would be refused."""
    study = (STUDIES / "dc_motor.toml").read_text(encoding="utf-8").replace("lag = 0.001 ", "lag = 0.0 ")
    study = study.replace('metric = "travel"', 'metric = "sway.angle"').replace(
        "[plant]", '[metric]\nfile = "sway.py"\n\n[plant]'
    )
    shutil.copy(SWAY, tmp_path)
    shutil.copy(STUDIES / "dc_motor.py", tmp_path)
    write_motor(tmp_path, 2)
    fmu = 'fmu = "motor.fmu"\ndisturbances = ["torque"]'
    scores = []
    for name, text in (("python", study), ("fmu", study.replace('file = "dc_motor.py"', fmu))):
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
        asked: Any = load_study(tmp_path / f"{name}.toml")
        problem = Problem(asked.system, asked.space, asked.objectives, asked.constraints, asked.seed, 1)
        batch = FlightBatch(asked.scenarios[0].spec, SEARCH, 2)
        scores.append(problem.evaluate_gains(asked.default_row[None], (batch,)).scores)
    assert scores[0][0, 1].min() > 0.0
    np.testing.assert_allclose(scores[1], scores[0], rtol=1e-6)


def test_a_law_of_no_file_is_refused(tmp_path):
    plant, plan, _ = closed(tmp_path, replace(LAWS["pid"], name="mine"))
    with pytest.raises(InputError, match="'mine' is a law of no file"):
        describe_loop(plant.interface, tmp_path, plan, (), TIMING, 1.0)
