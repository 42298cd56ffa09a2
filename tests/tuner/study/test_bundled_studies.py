"""The bundled tuning studies: each says what it asks, its default flies, its margins leave a choice, and it runs to the end."""

import json
import re
import tomllib
from functools import cache

import numpy as np
import pandas as pd
import pytest

from objectives.problem import FlightBatch, Problem
from plant.quadrotor.scenarios import SEARCH
from plant.seeds import generator
from tests.tuner.conftest import QUICKSTART
from tests.tuner.experiments.tuning.test_run import FILES
from tuner.api.catalogue import listings
from tuner.documents.summary import GAINS, INFEASIBLE
from tuner.experiments.tuning.run import TuningRun
from tuner.report.sheets import scenario_names
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.study.build import load_study

NAMES = (
    "ardupilot",
    "autopilot_pid",
    "betaflight",
    "crazyflie",
    "crazyflie_firmware",
    "f450",
    "figure_eight",
    "gust_rejection",
    "motor_lag",
    "payload_and_battery",
    "px4",
    "quickstart",
    "step_response",
)
# Studies whose laws the others do not fly: each pair of laws takes 10 to 20 s of compilation, so they are slow proofs.
OWN_KERNELS = ("ardupilot", "betaflight", "crazyflie_firmware", "f450", "motor_lag", "px4")
# The study of most scenarios takes longest, and flies by the laws of the quickstart.
FLOWN = [
    pytest.param(name, marks=pytest.mark.slow) if name in (*OWN_KERNELS, "payload_and_battery") else name
    for name in NAMES
]
each = pytest.mark.parametrize("name", NAMES)
flown = pytest.mark.parametrize("name", FLOWN)
# Studies of other scenarios alone, all the same until the report.
ALIKE = ("payload_and_battery", "figure_eight", "gust_rejection", "step_response")
# Draws of each scenario that the default flies, and random candidates of which this share at least must keep the margins: the
# first generation replaces those that do not, and finds enough where 3 % do.
FEW, RANDOM, SHARE = 4, 512, 0.003
# What the comment on the first line of a key must name.
UNITS = {
    "control_period": "s", "duration": "s", "search": "flights", "held_out": "flights", "recovery_from": "s", "x": "m",
    "y": "m", "z": "m", "time": "s", "size": "m", "altitude": "m", "amplitude": "m/s", "start": "s", "length": "s",
    "minimum_airspeed": "m/s", "position.omega_c": "rad/s", "attitude.kp": "1/s2", "attitude.lambda": "1/s",
}  # fmt: skip


def path_of(name):
    return QUICKSTART.parent / f"{name}.toml"


@cache
def study_of(name):
    return load_study(path_of(name))


def problem_of(study):
    return Problem(study.system, study.space, study.objectives, study.constraints, study.seed, 2, study.screens)


def test_no_tuning_study_is_left_out_and_all_are_listed(monkeypatch):
    tables = {path.stem: tomllib.loads(path.read_text()) for path in QUICKSTART.parent.glob("*.toml")}
    # Contests; studies of plants and of laws of one's own, which have tests of their own.
    others = {"base", "contender", "plant", "law"}
    assert {name for name, table in tables.items() if not others & set(table)} == set(NAMES)
    monkeypatch.chdir(QUICKSTART.parents[1])
    titles = {row["study"]: str(row["title"]) for row in listings()["studies"]()}
    assert len({titles[name] for name in NAMES}) == len(NAMES)


@each
def test_the_header_asks_a_question_and_tells_how_to_run_it(name):
    lines = path_of(name).read_text().splitlines()
    header = lines[: next(i for i, line in enumerate(lines) if not line.startswith("#"))]
    assert any(f"`tuner run studies/{name}.toml`" in line for line in header)
    # The quickstart shows how a study is written; what the others ask is their reason to be there.
    assert name == "quickstart" or ("?" in " ".join(header) and 5 <= len(header) <= 12)
    assert study_of(name).title and study_of(name).description.endswith(".")
    assert max(map(len, lines)) <= 130


@each
def test_a_key_names_its_unit_where_it_first_stands(name):
    comments = {}
    for key, comment in re.findall(r'^"?([\w.]+?)"? = [^#\n]*(?:# (.*))?$', path_of(name).read_text(), re.MULTILINE):
        comments.setdefault(key, comment)
    words = {key: re.split(r"[ ,:;]+", comment) for key, comment in comments.items()}
    assert [key for key, unit in UNITS.items() if key in words and unit not in words[key]] == []


@each
def test_it_asks_for_margins_for_no_lost_flight_and_for_a_budget_of_a_minute(name):
    study = study_of(name)
    labels = [requirement.label.partition("(")[0] for requirement in study.requirements]
    assert {"phase_margin", "gain_margin", "ms"} <= set(labels)
    assert any(entry.objective.metric.text == "failure" and entry.most == 0.0 for entry in study.constraints)
    assert 2 <= len(study.objectives) <= 3
    seconds = sum(entry.search * entry.spec.duration for entry in study.scenarios)
    # At 10 million plant steps a second and thread, on 4 threads.
    assert seconds * study.search.population * study.search.generations * 1000 / 4e7 < 60.0


@flown
def test_the_default_flies_every_scenario_and_margins_leave_a_choice(name):
    study = study_of(name)
    problem = problem_of(study)
    batches = tuple(FlightBatch(entry.spec, SEARCH, FEW) for entry in study.scenarios)
    flown = problem.evaluate_gains(study.default_row[None], batches, fly_all=True)
    assert flown.failures.tolist() == [0.0]
    points = generator(0, "bundled studies", 0).uniform(size=(RANDOM, len(study.space.variables)))
    assert SHARE <= problem.worth_flying(points).mean() <= 0.9


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow) if name in (*OWN_KERNELS, *ALIKE) else name
        for name in NAMES
        if name != "quickstart"
    ],
)
def test_shortened_it_runs_to_a_complete_folder(name, tmp_path, monkeypatch):
    scenarios = len(study_of(name).scenarios)
    few = {f"scenario.{i}.{key}": count for i in range(scenarios) for key, count in (("search", 4), ("held_out", 8))}
    study = load_study(path_of(name), {"search.population": 8, "search.generations": 2, **few})
    folder = tmp_path / name
    # Figures are drawn, but not written to files as pictures: that is most of the time, and the quickstart's own test does it.
    monkeypatch.setattr("tuner.report.charts.paper.printed", lambda figure: {"": b""})
    outcome = TuningRun(study, Folder.create(folder), Watcher(), threads=2).carry_out()
    # So short a search may find nothing feasible, as that of payload_and_battery does; it says so and recommends no gains.
    feasible = json.loads((folder / "summary.json").read_text())["feasible"]
    assert [file.name for file in (folder / GAINS, folder / INFEASIBLE) if file.exists()] == [
        GAINS if feasible else INFEASIBLE
    ]
    expected = [file for file in FILES if not file.startswith("figures") and file != GAINS]
    assert [file for file in expected if not (folder / file).stat().st_size] == []
    drawn = {file.name for file in (folder / "figures").iterdir()}
    assert drawn >= {"front", *scenario_names("responses", [entry.spec.name for entry in study.scenarios])}
    summary = json.loads((folder / "summary.json").read_text())
    assert [row["label"] for row in summary["table"]][: len(study.objectives)] == [o.label for o in study.objectives]
    front = pd.read_csv(folder / "front.csv")
    assert np.isfinite(front[[f"held_out:{objective.label}" for objective in study.objectives]].to_numpy()).all()
    values = outcome.finalists.evaluation
    assert not np.isnan(values.requirements).any() and values.failures[0] == 0.0
