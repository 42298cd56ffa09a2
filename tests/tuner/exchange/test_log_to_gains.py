"""The page from a log to gains, on a small search: a made log whose vehicle is known, and what its next flight should show."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tuner
from objectives.problem import FlightBatch, Problem
from plant.quadrotor.airframes import load
from plant.quadrotor.scenarios import HELD_OUT
from tests.tuner.extensions.identification.known_flights import known_flights
from tests.tuner.in_process import called
from tuner.gains import read_gains

PAGE = (Path(__file__).parents[3] / "docs" / "log_to_gains.md").read_text(encoding="utf-8")
STUDY = re.findall(r"^`mine_study.toml`[^\n]*:\n\n```toml\n(.*?)```", PAGE, re.MULTILINE | re.DOTALL)[0]
COMMANDS = [line.split() for line in re.findall(r"^(tuner .*)$", PAGE, re.MULTILINE)]
MAPPING = """
axes = "FLU"
time = { column = "t", unit = "s" }
gyro = { columns = ["p", "q", "r"], unit = "rad/s" }
acceleration = { columns = ["ax", "ay", "az"], unit = "m/s2" }
command = { columns = ["m1", "m2", "m3", "m4"], idle = 0, full = 1 }
"""
SMALL = {
    "search.population": 8,
    "search.generations": 2,
    "scenario.0.search": 4,
    "scenario.0.held_out": 16,
    "scenario.0.duration": 2.0,
    "margin.0.min": 12,
    "margin.1.max": 5,
    "mission.off": '["rms.position"]',
}


@pytest.fixture(scope="module")
def flight():
    return known_flights(1, duration=6.0, seed=19)[0]


def written(log, file):
    """A log as CSV."""
    rows = np.column_stack([log.time, log.gyro, log.acceleration, log.command])
    np.savetxt(file, rows, delimiter=",", header="t,p,q,r,ax,ay,az,m1,m2,m3,m4", comments="", fmt="%.9g")


@pytest.mark.slow
def test_a_log_becomes_gains_and_a_prediction_that_the_vehicle_behind_it_keeps(
    flight, tmp_path, monkeypatch, few_golden_vectors
):
    monkeypatch.chdir(tmp_path)
    written(flight.log, tmp_path / "log15.csv")
    (tmp_path / "columns.toml").write_text(MAPPING)
    (tmp_path / "mine_study.toml").write_text(STUDY)
    small = [text for key, value in SMALL.items() for text in ("--set", f"{key}={value}")]
    more = {
        "identify": ["--mapping", "columns.toml", "--json"],
        "run": [*small, "--json"],
        "export": ["--flights", "4", "--json"],
        "fly": ["--seeds", "32", "--json"],
    }
    said = {}
    for _, command, *arguments in COMMANDS:
        # There is no next log yet, and the whole way in one command is tried by test_autotuning.py.
        if command in ("compare-logs", "autotune"):
            continue
        given = [text.replace("log15", "log15.csv") for text in arguments]
        code, said[command], told = called(command, *given, *more[command])
        assert code == 0, told
    assert load("mine.toml").uncertainty is not None and Path("mine.html").exists()
    assert (tmp_path / "results" / "mine" / "export" / "crazyflie" / "export.json").exists()
    predicted = {row["metric"]: row for row in json.loads(said["fly"])["metrics"]}
    noise = predicted["noise"]
    assert 2.0 * noise["median"] - noise["worst"] < noise_on_the_truth(flight.vehicle, tmp_path) < noise["worst"]


def noise_on_the_truth(vehicle, folder):
    """Noise of the gains on the vehicle of the log, whose speeds are in its own scale; no flight may be lost."""
    study = tuner.load_study(folder / "mine_study.toml", {"scenario.0.spread": {}}, kind=tuner.Study)
    known, entry = study.airframe.vehicle, study.scenarios[0]
    share = (vehicle.speed_max / known.speed_max) ** 2
    truth = vehicle._replace(speed_max=known.speed_max, thrust_coefficient=vehicle.thrust_coefficient * share)
    problem = Problem(replace(study.system, vehicle=truth), study.space, study.objectives, (), study.seed, 1)
    gains = np.array([read_gains(folder / "results" / "mine" / "gains.json").gains])
    found = problem.evaluate_gains(gains, (FlightBatch(entry.spec, HELD_OUT, 16),), fly_all=True)
    assert found.lost[0] == 0
    return float(found.values[0, 1])
