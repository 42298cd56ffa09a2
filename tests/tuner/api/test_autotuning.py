"""From a log and a vehicle's parameters to tuned ones: each stage's file, resumption, edits between stages, and early ends."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tuner
from plant.errors import InputError, StoreError
from plant.quadrotor.airframes import load
from tests.tuner.analysis.identification.known_flights import known_flights
from tests.tuner.exchange.test_log_to_gains import MAPPING, written
from tuner.api import autotune_study as study_of
from tuner.api import autotuning
from tuner.api.assessing import FIRST_FLIGHT
from tuner.api.autotune_study import STUDIES, autotune_study
from tuner.api.autotuning import Stage
from tuner.api.vehicle_files import read_parameter_file

PRESENT = "type: persistent_param_state\nversion: '1'\nparams:\n  pid_rate.roll_kp: {default_value: 250.0, is_stored: true, stored_value: 200.0}\n"
FILES = {
    "crazyflie": ("present.yaml", PRESENT),
    "betaflight": ("diff.txt", "# Betaflight / STM32F405 (S405) 2025.12.1 Dec 20 2025 / 18:22:02 (77d01ba3b) MSP API: 1.47\nset p_pitch = 52\n"),
    "px4": ("quad.params", "# Stack: PX4 Pro\n# Version: 1.16.0\n1\t1\tMC_ROLLRATE_P\t0.12\t9\n"),
    "ardupilot": ("quad.param", "ATC_RAT_RLL_P,0.12\nATC_RAT_PIT_P,0.12\n"),
}  # fmt: skip
FLIGHT: Any = {"airframe": "crazyflie-pybullet", "mapping": "columns.toml"}


@pytest.fixture(scope="module")
def log():
    return known_flights(1, duration=6.0, seed=19)[0].log


@pytest.fixture
def place(log, tmp_path, monkeypatch):
    """A folder with a log and the vehicle's parameters."""
    monkeypatch.chdir(tmp_path)
    written(log, tmp_path / "log.csv")
    Path("columns.toml").write_text(MAPPING)
    Path("present.yaml").write_text(PRESENT)
    return tmp_path


@pytest.mark.parametrize("source", STUDIES)
@pytest.mark.parametrize("airframe", ["crazyflie-pybullet", "racer5", "f450"])
def test_the_study_of_every_firmware_and_size_loads(source, airframe, tmp_path):
    vehicle, (name, content) = load(airframe), FILES[source]
    (tmp_path / name).write_text(content)
    present = read_parameter_file(tmp_path / name, source, vehicle).gains
    present.write(tmp_path / "present.json")
    # A shipped airframe holds no set; the study of an identified one draws from it.
    text = autotune_study(source, vehicle, Path("vehicle.toml"), present, Path("present.json"))
    text = text.replace('file = "vehicle.toml"', f'name = "{airframe}"').replace('from = "airframe"', "mass = 0.1")
    (tmp_path / "study.toml").write_text(text)
    study = tuner.load_study(tmp_path / "study.toml", kind=tuner.Study)
    assert study.system.cascade.attitude.name == present.controller.cascade.attitude.name
    assert study.system.timing.control_period == present.controller.control_period
    assert {variable.name.partition(".")[0] for variable in study.space.variables} <= {"tilt", "attitude"}
    assert "tilt.p" in {variable.name for variable in study.space.variables}
    # The study flies what the result is judged by, with the gyro's noise of the log.
    flown = study.scenarios[0].spec
    assert (flown.reference, flown.air, flown.duration) == (
        FIRST_FLIGHT.reference,
        FIRST_FLIGHT.air,
        FIRST_FLIGHT.duration,
    )
    assert "\nrate = " not in text


def test_files_that_are_not_of_one_vehicle_are_refused_before_a_folder_is_made(place):
    (place / "quad.params").write_text(FILES["px4"][1])
    (place / "gains.json").write_text("{}")
    (place / "card").write_bytes((Path(__file__).parents[1] / "logs" / "crazyflie" / "log15_70_to_85").read_bytes())
    for logs, vehicle, message in [
        ("card", "quad.params", "is a log of crazyflie, and quad.params holds parameters of px4"),
        ("log.csv", "gains.json", "is no parameter file of a firmware"),
        ("log.csv", "missing.yaml", "missing.yaml"),
        ("missing.csv", "present.yaml", "missing.csv"),
    ]:
        with pytest.raises(InputError, match=message):
            tuner.autotune(
                logs, vehicle, "out", **(FLIGHT if logs.endswith(".csv") else {"airframe": FLIGHT["airframe"]})
            )
    assert not Path("out").exists()


def staged(monkeypatch, calls, ends=None):
    """Replace the stages by ones that write a file each; ends: the one that ends the way."""

    def stages(self):
        def make(name):
            def carry_out():
                calls.append(name)
                (self._out / f"{name}.txt").write_text(
                    f"{name} of {(self._out / 'a.txt').read_text() if name != 'a' else ''}"
                )
                return "too little" if name == ends else None

            return carry_out

        inputs = {"a": (), "b": ("a.txt",), "c": ("b.txt",)}
        return tuple(Stage(name, f"{name}.txt", read, make(name), lambda: "made") for name, read in inputs.items())

    monkeypatch.setattr(autotuning._Chain, "_stages", property(stages))


def test_a_call_goes_on_where_the_last_one_ended(place, monkeypatch):
    calls = []
    staged(monkeypatch, calls, ends="b")
    made = tuner.autotune("log.csv", "present.yaml", "out", **FLIGHT)
    assert not made.passed and made.document.sentence == "too little"
    assert [(row.stage, row.state) for row in made.document.stages] == [("a", "done"), ("b", "stopped")]
    assert json.loads(Path("out/autotune.json").read_text())["sentence"] == "too little"
    assert "too little" in Path("out/index.html").read_text()
    calls.clear()
    tuner.autotune("log.csv", "present.yaml", "out", **FLIGHT)
    assert calls == ["b"]
    # A file that was edited before the next stage read it is used; after that it is not silently ignored.
    Path("out/a.txt").write_text("mine")
    tuner.autotune("log.csv", "present.yaml", "out", **FLIGHT)
    assert Path("out/b.txt").read_text() == "b of mine"
    Path("present.yaml").write_text(PRESENT.replace("200.0", "210.0"))
    with pytest.raises(StoreError, match="holds an autotune of other files"):
        tuner.autotune("log.csv", "present.yaml", "out", **FLIGHT)


def test_a_file_that_changed_after_it_was_read_names_what_to_remove(place, monkeypatch):
    calls = []
    staged(monkeypatch, calls, ends="c")
    tuner.autotune("log.csv", "present.yaml", "out", **FLIGHT)
    Path("out/a.txt").write_text("mine")
    with pytest.raises(StoreError, match="a.txt changed after the b; remove out/b.txt"):
        tuner.autotune("log.csv", "present.yaml", "out", **FLIGHT)


@pytest.mark.slow
def test_a_log_and_parameters_become_tuned_parameters_an_opinion_and_first_flights(place, monkeypatch):
    monkeypatch.setattr(study_of, "SEARCH", {"algorithm": "nsga2", "population": 8, "generations": 2})
    monkeypatch.setattr(study_of, "HELD_OUT", 16)
    monkeypatch.setattr(study_of, "LIMITS", (("phase_margin", "min", 12.0), ("ms", "max", 5.0)))
    made = tuner.autotune("log.csv", "present.yaml", "out", **FLIGHT)
    names = [row.stage for row in made.document.stages]
    assert names == ["identification", "import", "study", "search", "export", "opinion", "first flights"]
    assert all(row.state == "done" and row.sentence for row in made.document.stages)
    opinion = json.loads(Path("out/opinion/assessment.json").read_text())
    # Default and tuned gains are of one vehicle: nothing changes that is not searched.
    assert all(row["name"].startswith(("roll", "pitch")) for row in opinion["changes"])
    page = Path("out/index.html").read_text()
    assert "&lt;h3" not in page and opinion["sentence"].partition(":")[0] in page
    assert all(
        Path("out", name).exists() for name in ("run/report.html", "vehicle.html", "opinion/judge.md", "first_flights")
    )
    again = tuner.autotune("log.csv", "present.yaml", "out", **FLIGHT)
    assert [row.seconds for row in again.document.stages] == [0.0] * len(names)
    assert [row.sentence for row in again.document.stages] == [row.sentence for row in made.document.stages]
    Path("out/study.toml").write_text(Path("out/study.toml").read_text() + "\n")
    with pytest.raises(StoreError, match="changed after the search; remove out/run"):
        tuner.autotune("log.csv", "present.yaml", "out", **FLIGHT)


@pytest.mark.slow
def test_a_log_that_tells_too_little_ends_with_the_flight_that_would(place, log, monkeypatch):
    calm = type(log)(
        **{**log.__dict__, "command": np.where(np.arange(len(log.time))[:, None] % 10 == 0, 1.0, log.command)}
    )
    written(calm, place / "calm.csv")
    made = tuner.autotune("calm.csv", "present.yaml", "out", **FLIGHT)
    assert not made.passed and made.document.stages[-1].state == "stopped"
    assert "tells nothing" in made.document.sentence and "give its log" in made.document.sentence
    assert Path("out/plan/plan.json").exists() and "plan.html" in Path("out/index.html").read_text()
