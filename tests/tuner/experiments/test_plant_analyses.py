"""`tuner sensitivity` and `tuner plan` of a plant of one's own: a gain without effect has none, flights are those that are made."""

import json
from typing import Any

import numpy as np
import pytest

from tests.tuner.experiments.own_motor import STUDY, write_motor
from tests.tuner.in_process import tuner
from tuner.api.planning import plan
from tuner.api.studies import load_study
from tuner.experiments.tuning.problem import batches
from tuner.experiments.tuning.run import TuningRun
from tuner.extensions.sensitivity.api import sensitivity
from tuner.extensions.sensitivity.indices import VALUE
from tuner.extensions.sensitivity.run import study_problem
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.study.plant_study import PlantStudy

SMALL = {
    "search.algorithm": "nsga2",
    "search.population": 8,
    "search.generations": 2,
    "search.racing": False,
    "scenario.0.search": 4,
    "scenario.0.held_out": 16,
}


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The study, its integral gain searched over a range that changes nothing."""
    still = STUDY.replace("{ low = 0.01, high = 50.0, default = 0.1 }", "{ low = 0.1, high = 0.10000001 }")
    return write_motor(tmp_path_factory.mktemp("motor"), still)


def test_a_gain_without_a_range_decides_nothing_and_samples_are_flights(file):
    study = load_study(file, kind=PlantStudy)
    found = sensitivity(study, samples=16, threads=2)
    total, names = found.analysis.indices[VALUE].total.value, [variable.name for variable in study.space.variables]
    assert np.abs(total[0, names.index("angle.ki")]) < 1e-8 < total[0, names.index("angle.kp")]
    assert [entry.unit for entry in found.document.variables] == ["V/rad", "V/rad/s", "V s/rad"]
    again = study_problem(study, 1).evaluate(
        found.analysis.design.points[[3, 60]], batches(study, "search"), fly_all=True
    )
    assert np.array_equal(again.values, found.analysis.values[[3, 60]])


def test_the_command_writes_tables_and_figure_and_prints_one_document(file, tmp_path, monkeypatch, capsys):
    code, out, err = tuner(
        monkeypatch, capsys, "sensitivity", file, "--samples", "8", "--out", tmp_path / "s", "--json"
    )
    assert code == 0, err
    assert json.loads(out)["variables"][0]["name"] == "angle.kp"
    assert {"sensitivity.json", "indices.csv", "samples.csv", "figures"} <= {
        entry.name for entry in (tmp_path / "s").iterdir()
    }


def test_a_plan_counts_the_flights_that_a_run_makes(file, tmp_path):
    study = load_study(file, {**SMALL, "margin": []}, kind=PlantStudy)
    planned: Any = plan(study, threads=2).document
    made = TuningRun(study, Folder.create(tmp_path / "r"), Watcher(), threads=2).carry_out()
    assert planned.flights.search_at_most == made.generations[-1].flights == 8 * 2 * 4
    assert made.flights == 8 * 2 * 4 + (len(made.candidates) + 3) * planned.flights.held_out_each


def test_the_plan_of_a_plant_is_printed(file, monkeypatch, capsys):
    code, out, err = tuner(monkeypatch, capsys, "plan", file, "--json")
    assert code == 0, err
    document = json.loads(out)
    assert document["plant_step"]["steps"] == 2
    assert document["objectives"][0]["unit"] == "rad"
