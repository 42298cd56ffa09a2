"""Flights of an export and of an approach: in air that the tilt limit holds, and lost ones are told first, with exit code 1."""

import json
from dataclasses import replace
from math import degrees, radians

import numpy as np
import pytest

from plant.quadrotor.airframes import load
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.trim import trim_of
from tests.tuner.exchange.controllers import pid
from tests.tuner.in_process import tuner
from tuner.analysis.responses import SCENARIO, system_of, usual_scenario
from tuner.exchange.verification import fly_both, quadrotor_loops
from tuner.gains import Controller, to_document
from tuner.search.watcher import Watcher


@pytest.fixture
def run(monkeypatch, capsys):
    """Run a command and return exit code, standard output and standard error."""
    return lambda *arguments: tuner(monkeypatch, capsys, *arguments)


def on(airframe: str) -> Controller:
    """Return PID gains on an airframe, of slower position loops."""
    given, frame = pid(), load(airframe)
    row = np.array(given.gains)
    for gain in gain_addresses(given.cascade):
        if gain.axis in ("x", "y", "z"):
            row[gain.column] *= 0.5
    return replace(given, airframe=frame, gains=tuple(row.tolist()))


@pytest.mark.parametrize(("airframe", "milder"), [("hummingbird", False), ("f450", False), ("racer5", True)])
def test_the_wind_leaves_a_third_of_the_tilt_limit(airframe: str, milder: bool) -> None:
    system = system_of(on(airframe))
    spec = usual_scenario(system)
    tilts = [
        degrees(
            trim_of(system.vehicle, (spec.air.wind_speed * np.cos(a), spec.air.wind_speed * np.sin(a), 0.0)).tilt[0]
        )
        for a in np.linspace(0.0, radians(90.0), 7)
    ]
    assert max(tilts) < 20.5
    assert (spec is not SCENARIO) == milder and spec.air.wind_speed > 4.0


def test_a_racer_loses_no_flight_of_the_verification() -> None:
    """In a fresh breeze, which which its tilt limit of 30 deg does not hold, it lost 35 of 64."""
    loops = quadrotor_loops(on("racer5"))
    metrics, lost = fly_both(loops, loops, 64, Watcher())
    assert lost == (0, 0) and "4.7 m/s" in loops.spec.name
    assert all(row.unrounded is not None for row in metrics)


def falling() -> Controller:
    """Return gains whose position loops hardly hold their place: most flights drift away and are lost."""
    given = on("f450")
    row = np.array(given.gains)
    for gain in gain_addresses(given.cascade):
        if gain.axis in ("x", "y"):
            row[gain.column] *= {"kp": 0.01, "ki": 0.0, "kd": 0.3}.get(gain.info.name, 1.0)
    return replace(given, gains=tuple(row.tolist()))


def test_lost_flights_come_first_with_exit_code_1_and_are_in_no_mean(run, tmp_path) -> None:
    _, lost = fly_both(quadrotor_loops(falling()), quadrotor_loops(falling()), 16, Watcher())
    assert 0 < lost[0] < 16, lost
    file = tmp_path / "gains.json"
    file.write_text(json.dumps(to_document(falling(), {})))
    code, told, said = run("export", file, "--to", "c99", "--out", tmp_path / "out", "--flights", "16")
    assert code == 1, said
    assert told.splitlines()[0].startswith(f"{lost[0]} of 16 flights lost")
    part = json.loads((tmp_path / "out" / "export.json").read_text())["verification"]
    assert part["lost_asked"] == part["lost_held"] == lost[0] and not part["passed"]


def test_an_approach_names_lost_flights_and_expects_nothing_of_them(run, tmp_path) -> None:
    files = [tmp_path / "present.json", tmp_path / "tuned.json"]
    for file, given in zip(files, (on("f450"), falling()), strict=True):
        file.write_text(json.dumps(to_document(given, {})))
    code, told, said = run("approach", *files, "--steps", "1", "--flights", "16", "--json")
    assert code == 1, said
    first, last = json.loads(told)["steps"]
    assert first["lost"] == 0 and last["lost"] > 0
    # 5 m is where a flight is lost: no flight that is completed has that RMS.
    by_metric = {row["metric"]: row for row in last["expected"]}
    assert 0.5 < by_metric["rms.position"]["high"] < 5.0
    code, told, said = run("approach", *files, "--steps", "1", "--flights", "16")
    assert code == 1 and told.splitlines()[0].startswith(f"Step 1: {last['lost']} of 16 flights lost")
