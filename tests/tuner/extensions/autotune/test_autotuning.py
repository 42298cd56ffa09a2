"""From a log and a vehicle's parameters to tuned ones: each stage's file, resumption, edits between stages, and early ends."""

import json
import shutil
import signal
import subprocess
import sys
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import tuner
from plant.errors import InputError, StoreError, ToolError
from plant.quadrotor.airframes import load
from tests.opened_files import opened_files
from tests.tuner.exchange.test_log_to_gains import MAPPING, written
from tests.tuner.experiments.again.killing import compare, result_of
from tests.tuner.extensions.autotune.standin_stages import (
    FLIGHT,
    KILLED,
    NAMES,
    STANDINS,
    Standin,
    StandinExport,
    StandinOpinion,
    contents,
    replace_stages,
    tuned,
)
from tests.tuner.extensions.identification.known_flights import known_flights
from tuner.documents.assessment import REFUSED
from tuner.extensions.autotune import stages as stages
from tuner.extensions.autotune import study as study_of
from tuner.extensions.autotune.study import STUDIES, autotune_study
from tuner.extensions.identification import api as identifying
from tuner.extensions.judge.scenarios import FIRST_FLIGHT
from tuner.extensions.judge.vehicle_files import read_parameter_file
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.step_records.keyed_folder import KeyedFolder

PRESENT = "type: persistent_param_state\nversion: '1'\nparams:\n  pid_rate.roll_kp: {default_value: 250.0, is_stored: true, stored_value: 200.0}\n"
FILES = {
    "crazyflie": ("present.yaml", PRESENT),
    "betaflight": ("diff.txt", "# Betaflight / STM32F405 (S405) 2025.12.1 Dec 20 2025 / 18:22:02 (77d01ba3b) MSP API: 1.47\nset p_pitch = 52\n"),
    "px4": ("quad.params", "# Stack: PX4 Pro\n# Version: 1.16.0\n1\t1\tMC_ROLLRATE_P\t0.12\t9\n"),
    "ardupilot": ("quad.param", "ATC_RAT_RLL_P,0.12\nATC_RAT_PIT_P,0.12\n"),
}  # fmt: skip


@pytest.fixture(scope="module")
def log():
    return known_flights(1, duration=6.0, seed=19)[0].log


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a log that no stage but a stand-in could use, and the vehicle's parameters."""
    monkeypatch.chdir(tmp_path)
    time, still = np.arange(0.0, 6.0, 0.008), np.zeros((750, 3))
    written(
        FlightLog("log", "made", "0" * 64, time, still, still + [0.0, 0.0, 9.81], np.full((750, 4), 0.5)), "log.csv"
    )
    Path("columns.toml").write_text(MAPPING)
    Path("present.yaml").write_text(PRESENT)
    return tmp_path


@pytest.fixture
def flown(place, log):
    """The folder with the log of a flight."""
    written(log, place / "log.csv")
    return place


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A function that leaves what `tuned` does with the stand-ins on the inputs of `place`: made once, then copied."""
    made = {}

    def finish(**given):
        key = tuple(given.items())
        if key not in made:
            made[key] = tmp_path_factory.mktemp("finished") / "out"
            assert tuned(**given).passed
            shutil.copytree("out", made[key])
        else:
            shutil.copytree(made[key], "out")

    return finish


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


@pytest.fixture
def calls(monkeypatch):
    """Replace the stages by quick ones; the list of those that are made."""
    return replace_stages(monkeypatch)


def test_a_call_goes_on_where_the_last_one_ended(place, calls, monkeypatch):
    monkeypatch.setattr(Standin, "ends", "search")
    made = tuned()
    assert not made.passed and made.document.sentence == "too little"
    assert [(row.stage, row.state) for row in made.document.stages][-2:] == [("study", "done"), ("search", "stopped")]
    assert json.loads(Path("out/autotune.json").read_text())["sentence"] == "too little"
    calls.clear()
    tuned()
    assert calls == ["search"]
    # A file that was edited before the next stage read it is used; an ended way begins again from it, not from its old run/.
    edit("out/study.toml", "generations = 12", "generations = 13")
    monkeypatch.setattr(Standin, "ends", None)
    made = tuned()
    assert made.passed and [row.stage for row in made.document.stages] == NAMES
    assert "generations = 13" in Path("out/run/gains.json").read_text()
    calls.clear()
    again = tuned()
    assert calls == [] and [row.seconds for row in again.document.stages] == [0.0] * len(NAMES)


def edit(file, old, new):
    text = Path(file).read_text()
    assert old in text
    Path(file).write_text(text.replace(old, new, 1))


def other_airframe(place):
    (place / "mine.toml").write_text(load("crazyflie-pybullet").path.read_text())


INPUTS = {
    "log": (lambda: edit("log.csv", "\n0,", "\n0.0,"), {}, "logs changed", "identification"),
    "part of a log": (lambda: None, {"logs": "log.csv@1:5"}, r"logs changed \(part of log 1 0 to .* -> 1 to 5 s\)", "identification"),
    "further log": (lambda: None, {"logs": ["log.csv@0:2", "log.csv@3:5"]}, r"logs changed \(number 1 -> 2", "identification"),
    "mapping": (lambda: edit("columns.toml", "idle = 0", "idle = 0.0"), {}, r"mapping file changed \(command.idle 0 -> 0.0\)", "identification"),
    "airframe": (lambda: edit("mine.toml", "0.027", "0.0305"), {}, r"airframe file changed \(mass 0.027 -> 0.0305\)", "identification"),
    "other airframe": (lambda: None, {"airframe": "crazyflie-rotors"}, r"airframe file changed \(title ", "identification"),
    "version": ("version", {}, r"version of the product changed \(version .* -> 99.0\)", "identification"),
    "parameters": (lambda: edit("present.yaml", "200.0", "210.0"), {}, "parameter file changed", "import"),
    "vehicle": (lambda: edit("out/vehicle.toml", "0.027", "0.028"), {}, r"vehicle.toml changed \(mass 0.027 -> 0.028\)", "import"),
    "present gains": (lambda: edit("out/present.json", '"version"', ' "version"'), {}, "present.json changed", "study"),
    "copy of the parameters": (lambda: edit("out/present.yaml", "200.0", "210.0"), {}, "present.yaml changed", "export"),
    "study": (lambda: edit("out/study.toml", "seed = 2026", "seed = 2027"), {}, r"study.toml changed \(seed 2026 -> 2027\)", "search"),
    "study's comment": (lambda: edit("out/study.toml", "seed", "# mine\nseed"), {}, "study.toml changed after", "search"),
    "result": (lambda: edit("out/run/gains.json", "seed", "sead"), {}, "gains.json changed", "export"),
    "export": (lambda: edit("out/export/parameters", "export", "mine"), {}, "exported parameters changed", "opinion"),
    "program": (lambda: edit("firmware", "built", "built again"), {}, "program of the firmware changed", "confirmation"),
}  # fmt: skip


@pytest.mark.parametrize("name", INPUTS)
def test_a_changed_input_is_refused_by_its_name_and_made_again_on_demand(name, place, calls, finished, monkeypatch):
    change, given, sentence, stage = INPUTS[name]
    other_airframe(place)
    Path("firmware").write_text("built")
    usual = {"airframe": "mine.toml", "binary": "firmware"}
    finished(**usual)
    before = contents()
    if change == "version":
        monkeypatch.setattr(stages, "version", lambda: "99.0")
    else:
        change()
    edited = contents()
    calls.clear()
    with pytest.raises(StoreError, match=sentence) as refused:
        tuned(**(usual | given))
    assert "\n" not in str(refused.value)
    assert f"with --out, or make it again with --restart {stage}" in str(refused.value)
    assert calls == [] and contents() == edited
    # The advice of the message works, in both of its forms; a new folder knows of no input before.
    if name == "log":
        assert tuned(**(usual | given), out="elsewhere").passed
        calls.clear()
    assert tuned(**(usual | given), restart=stage).passed
    assert calls == [each.name for each in STANDINS][[each.name for each in STANDINS].index(stage) :]
    calls.clear()
    assert tuned(**(usual | given)).passed and calls == []
    assert contents()["stages.json"] != before["stages.json"]


@pytest.mark.parametrize("name", ["airframe", "study"])
def test_a_search_that_was_killed_never_goes_on_with_another_study(name, place, calls):
    """An edited study.toml was recorded as searched, and run/ held the old one."""
    other_airframe(place)
    calls.append(KILLED)
    with pytest.raises(KeyboardInterrupt):
        tuned(airframe="mine.toml")
    INPUTS[name][0]()
    with pytest.raises(StoreError, match=INPUTS[name][2]):
        tuned(airframe="mine.toml")
    assert tuned(airframe="mine.toml", restart=INPUTS[name][3]).passed
    assert Path("out/run/gains.json").read_text() == Path("out/study.toml").read_text()


@pytest.mark.parametrize("stage", NAMES)
def test_a_call_that_was_killed_at_any_stage_ends_with_the_same_bytes(stage, place, calls, finished, monkeypatch):
    finished()
    Path("out").rename("whole")
    kind = next(each for each in STANDINS if each.name == stage)
    make = kind.make

    def killed(self):
        make(self)
        raise KeyboardInterrupt

    monkeypatch.setattr(kind, "make", killed)
    with pytest.raises(KeyboardInterrupt):
        tuned()
    monkeypatch.setattr(kind, "make", make)
    assert tuned().passed
    assert contents() == contents("whole")


DAMAGES = (b"", b"\x00\xff\x80", *(pytest.param(text, marks=pytest.mark.slow) for text in (b"null", b"= nonsense")))


@pytest.mark.parametrize("content", DAMAGES)
@pytest.mark.parametrize(
    "name", ["stages.json", "study.toml", "vehicle.toml", "present.json", "run/gains.json", "export/export.json"]
)
def test_a_damaged_folder_is_refused_in_one_line_or_made_again(name, content, place, calls, finished):
    finished()
    Path("out", name).write_bytes(content)
    with pytest.raises(ToolError) as refused:
        tuned()
    assert str(refused.value).isprintable() and ("--out" in str(refused.value) or name in str(refused.value))
    if name != "stages.json":
        made_by = {
            "study.toml": "study",
            "present.json": "import",
            "run/gains.json": "search",
            "export/export.json": "export",
        }
        assert tuned(restart=made_by.get(name, "identification")).passed


def test_what_a_killed_export_left_is_removed(place, calls, monkeypatch):
    def killed(self):
        (self.out / ".export.part123").mkdir()
        raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(StandinExport, "make", killed)
        tuned()
    assert tuned().passed
    assert not list(Path("out").glob("*part*")) and Path("out/export/export.json").exists()


def test_the_firmware_may_be_given_later(place, calls):
    tuned()
    calls.clear()
    Path("firmware").write_text("built")
    assert tuned(binary="firmware").passed and calls == ["confirmation"]
    calls.clear()
    assert tuned().passed and calls == []


@pytest.mark.parametrize("verdict", ["worse", "do not fly"])
def test_gains_that_the_opinion_refuses_leave_no_export_and_plan_no_flight(verdict, place, calls, monkeypatch):
    opinions = iter([verdict, verdict, "mixed"])

    def judged(after, before, *, out, **options):
        assert Path(after).exists() and Path(before).exists()
        Path(out).write_text("an opinion")
        return SimpleNamespace(
            passed=(word := next(opinions)) not in REFUSED, document=SimpleNamespace(sentence=f"{word}: noise.")
        )

    monkeypatch.setattr(stages, "judge", judged)
    monkeypatch.setattr(StandinOpinion, "make", stages.OpinionStage.make)
    monkeypatch.setattr(StandinOpinion, "sentence", lambda self: "Mixed.")
    for _ in range(2):
        made = tuned()
        assert not made.passed and [row.stage for row in made.document.stages] == NAMES[: NAMES.index("opinion") + 1]
        assert made.document.stages[-1].state == "stopped"
        assert made.document.sentence.startswith(f"{verdict}: noise. No export is left, and no flight is planned")
        assert Path("out/run/gains.json").exists() and Path("out/opinion").exists()
        assert not Path("out/export").exists() and not Path("out/first_flights").exists()
    # Whoever gives the command again has the export made again; the opinion of today decides.
    assert tuned().passed and Path("out/export/parameters").exists() and Path("out/first_flights").exists()


@pytest.mark.parametrize("given", ["log.csv", "log.csv@0:5"])
def test_each_log_is_read_once(given, flown, monkeypatch):
    """Check and fit get the logs whose digests are on record."""
    fitted = []

    def end(logs, *_, **__):
        fitted.extend(logs)
        raise InputError("the fit was reached")

    monkeypatch.setattr(identifying, "identify_vehicle", end)
    paths = opened_files(monkeypatch)
    with pytest.raises(InputError, match="the fit was reached"):
        tuned(logs=[given])
    assert paths.count(flown / "log.csv") == 1
    (log,) = fitted
    assert log.digest == sha256(Path("log.csv").read_bytes()).hexdigest() and log.name == "log.csv"


def test_an_unknown_stage_is_refused_before_a_folder_is_made(place, calls):
    with pytest.raises(InputError, match=r"--restart: unknown stage 'serch'; did you mean 'search'\?"):
        tuned(restart="serch")
    assert not Path("out").exists()


def test_a_folder_of_a_tail_is_refused(place, calls):
    with KeyedFolder.begin(Path("out"), "tail") as keyed:
        keyed.start("tail", {}, "")
    with pytest.raises(StoreError, match="out holds a tail and no autotune; choose another folder with --out"):
        tuned()


@pytest.mark.slow
def test_a_log_and_parameters_become_tuned_parameters_an_opinion_and_first_flights(flown, monkeypatch):
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
    with pytest.raises(StoreError, match="study.toml changed after the search was begun"):
        tuner.autotune("log.csv", "present.yaml", "out", **FLIGHT)


SMALL = """
import os, signal, sys
from pathlib import Path
import tuner
from tuner.api import autotune_study as study_of

study_of.SEARCH = {"algorithm": "nsga2", "population": 8, "generations": 2}
study_of.HELD_OUT = 16
study_of.LIMITS = (("phase_margin", "min", 12.0), ("ms", "max", 5.0))
left, replace, link = int(sys.argv[2]), os.replace, os.link


def killed_after(rename):
    def renamed(source, target):
        global left
        rename(source, target)
        left -= 1
        if not left:
            os.kill(os.getpid(), signal.SIGKILL)

    return renamed


os.replace, os.link = killed_after(replace), killed_after(link)
made = tuner.autotune("log.csv", "present.yaml", sys.argv[1], airframe="crazyflie-pybullet", mapping="columns.toml", threads=1)
print(-left, made.passed, [row.stage for row in made.document.stages])
"""
"""An autotune on a small search that kills itself after so many new names of files, 0 for never."""
KILLS = 10
TIMED = ("environment.json", "summary.json", "history.csv", "report.html")
"""Files that hold times or the machine's state."""


@pytest.mark.slow
def test_ten_kills_across_all_stages_leave_the_bytes_of_an_undisturbed_call(flown):
    place = flown
    # Documents hold paths as they were given, so both calls have the same.
    for home in ("whole", "killed"):
        (place / home).mkdir()
        for name in ("log.csv", "columns.toml", "present.yaml"):
            shutil.copy(place / name, place / home)

    def call(home, left):
        command = [sys.executable, "-c", SMALL, "out", str(left)]
        return subprocess.run(command, cwd=place / home, capture_output=True, text=True, check=False)

    undisturbed = call("whole", 0)
    assert undisturbed.returncode == 0, undisturbed.stderr
    names = int(undisturbed.stdout.split()[0])
    stages_begun = []
    for kill in range(KILLS):
        # Nearer and nearer to the end: every call makes what is left of the one before.
        done = call("killed", max(names * (kill + 1) // (3 * KILLS), 2))
        if done.returncode == 0:
            break
        assert done.returncode == -signal.SIGKILL, done.stderr
        file = place / "killed" / "out" / "stages.json"
        record = json.loads(file.read_text()) if file.exists() else {"steps": []}
        stages_begun.append(record["steps"][-1]["name"] if record["steps"] else None)
    assert len(stages_begun) == KILLS and len(set(stages_begun)) >= 4, stages_begun
    last = call("killed", 0)
    assert last.returncode == 0 and last.stdout.split()[1:] == undisturbed.stdout.split()[1:], last.stderr
    killed, whole = contents("killed/out"), contents("whole/out")
    assert killed.keys() == whole.keys()
    for each in (killed, whole):
        # The times of the opinion stand among its results.
        opinion = json.loads(each["opinion/assessment.json"])
        assert opinion.pop("seconds")
        each["opinion/assessment.json"] = json.dumps(opinion).encode()
    assert [name for name in whole if killed[name] != whole[name] and Path(name).name not in TIMED] == []
    compare(result_of(place / "killed/out/run"), result_of(place / "whole/out/run"))


@pytest.mark.slow
def test_a_log_that_tells_too_little_ends_with_the_flight_that_would(place, log, monkeypatch):
    calm = type(log)(
        **{**log.__dict__, "command": np.where(np.arange(len(log.time))[:, None] % 10 == 0, 1.0, log.command)}
    )
    written(calm, place / "calm.csv")
    made = tuner.autotune("calm.csv", "present.yaml", "out", **FLIGHT)
    assert not made.passed and made.document.stages[-1].state == "stopped"
    assert "does not identify" in made.document.sentence and "give its log" in made.document.sentence
    assert Path("out/plan/plan.json").exists() and "plan.html" in Path("out/index.html").read_text()
