"""A contest on a plant of one's own: the same air for all, each contender the run that it is alone, and what does not fit is refused."""

import json
from pathlib import Path

import numpy as np
import pytest

from objectives.problem import FlightBatch, Problem
from plant.quadrotor.scenarios import CONFIRMATION
from tests.tuner.experiments.own_motor import STUDY, write_motor
from tests.tuner.in_process import called, tuner
from tests.tuner.study.loading import load_contest
from tuner.documents.opening import open_results

SMALL = '[search]\nalgorithm = "nsga2"\npopulation = 8\ngenerations = 2\nracing = false\n'
BASE = (
    STUDY[: STUDY.index("[search]")].replace("search = 16", "search = 4").replace("held_out = 64", "held_out = 16")
    + SMALL
)
ADRC = """
[[contender]]
name = "PID"

[[contender]]
name = "ADRC"
channel.angle = { law = "ladrc", b0 = 2122.0 }

[contender.gains]
"angle.omega_c" = { low = 10.0, high = 80.0, default = 20.0 }
"angle.zeta" = 1.0
"angle.omega_o" = { low = 40.0, high = 300.0, default = 80.0 }
"""
CLAIM = '\n[[claim]]\nbetter = "ADRC"\nthan = "PID"\nin = "itae.angle"\n'


@pytest.fixture(scope="module")
def contest(tmp_path_factory):
    """The contest and its results folder."""
    file = write_motor(tmp_path_factory.mktemp("motor"), BASE + ADRC + CLAIM)
    code, _, err = called("run", str(file), "--out", str(file.parent / "r"))
    assert code == 0, err
    return file, file.parent / "r"


def document(folder: Path):
    return json.loads((folder / "contest.json").read_text(encoding="utf-8"))


def test_the_document_tells_the_plant_and_the_law_of_each_channel(contest):
    rows = document(contest[1])["contenders"]
    assert [(row["plant"], row["channels"]) for row in rows] == [
        ("motor", {"angle": "pid"}),
        ("motor", {"angle": "ladrc"}),
    ]
    assert all(row["cost"]["operations"] == row["cost"]["channels"]["angle"] > 0 for row in rows)
    assert not {"airframe", "laws"} & rows[0].keys()
    signals = {fan.signal for fan in open_results(contest[1]).fans}
    assert signals == {"angle", "voltage"}


def test_the_mission_stands_at_the_top_and_holds_for_all(contest, tmp_path):
    path = write_motor(tmp_path, BASE + "[mission]\nfollowed = 0.5\n" + ADRC)
    for entry in load_contest(path).contenders:
        assert {each.objective.label: each.most for each in entry.study.automatic_limits} == {
            "quantile50(rms.angle)@step": pytest.approx(0.5)
        }
    rows = json.loads((contest[1] / "contenders/adrc/summary.json").read_text(encoding="utf-8"))["table"]
    assert [row["label"] for row in rows if row.get("automatic")] == ["quantile50(rms.angle)@step"]


def test_every_contender_flies_the_same_confirmation_flights(contest):
    """The scores of the table are those of each study's own problem on a stream that no search saw."""
    asked, rows = load_contest(contest[0]), document(contest[1])
    for contender, row in zip(asked.contenders, rows["contenders"], strict=True):
        study = contender.study
        gains = np.array([[row["gains"][gain.address]["value"] for gain in study.system.gains]])
        batch = FlightBatch(study.scenarios[0].spec, CONFIRMATION, 16)
        found = Problem(study.system, study.space, study.objectives, (), study.seed, 1).evaluate_gains(gains, (batch,))
        estimates = {e["quantity"]: e["value"] for e in rows["estimates"] if e["contender"] == contender.name}
        assert [estimates[objective.label] for objective in study.objectives] == pytest.approx(
            found.values[0], rel=1e-12
        )


def test_a_contender_alone_is_the_run_that_it_was_in_the_contest(contest, tmp_path, monkeypatch, capsys, no_figures):
    file = contest[1] / "contenders/adrc.toml"
    code, _, err = tuner(
        monkeypatch, capsys, "run", file, "--out", tmp_path / "alone", "--code", contest[0].with_name("motor.py")
    )
    assert code == 0, err
    for name in ("front.csv", "gains.json"):
        ours, theirs = ((folder / name).read_bytes() for folder in (tmp_path / "alone", contest[1] / "contenders/adrc"))
        assert ours == theirs, name


def test_other_channels_meet_the_same_motors_loads_and_noise(tmp_path):
    """A cascade beside a single loop: what is drawn has the names of what it is of."""
    inner = 'channel = [{ name = "angle", law = "pid", output = "angle", to = "speed", lost_beyond = 10.0 },'
    inner += ' { name = "speed", law = "pid", output = "angle", to = "voltage" }]\n[contender.gains]\n'
    gains = "".join(f'"{name}.{gain}" = 0.01\n' for name in ("angle", "speed") for gain in ("kp", "ki", "kd", "t_f"))
    file = write_motor(tmp_path, f'{BASE}\n[[contender]]\nname = "one"\n\n[[contender]]\nname = "two"\n{inner}{gains}')
    one, two = (contender.study for contender in load_contest(file).contenders)
    spec = one.scenarios[0].spec
    drawn = [study.system.sample(spec, 7, CONFIRMATION, range(3)) for study in (one, two)]
    assert len(two.system.laws) == 2
    for part in ("dynamics", "starts", "disturbances", "noises"):
        assert np.array_equal(*[getattr(inputs, part) for inputs in drawn]), part


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "channel.angle = {",
            "channel.angel = {",
            "contender[1].channel.angel: unknown channel 'angel'; did you mean 'angle'?",
        ),
        ('law = "ladrc",', 'law = "ladrcc",', "contender[1].channel[0].law: unknown law 'ladrcc'"),
        (
            "b0 = 2122.0 }",
            "b0 = 2122.0, lost_beyond = 3.0 }",
            "'ADRC' is judged by angle (output angle, limit 3), 'PID' by angle",
        ),
        ('name = "ADRC"', 'name = "ADRC"\nscenario = []', "'scenario' is the same for all contenders"),
        ('name = "ADRC"', 'name = "ADRC"\ncontroller.attitude = "pid"', "contender[1].controller"),
        ('in = "itae.angle"', 'in = "itae.roll"', "unknown metric address 'itae.roll'"),
    ],
)
def test_what_does_not_fit_is_one_line_with_its_key(tmp_path, monkeypatch, capsys, old, new, said):
    text = BASE + ADRC + CLAIM
    assert old in text
    code, _, err = tuner(monkeypatch, capsys, "check", write_motor(tmp_path, text.replace(old, new, 1)))
    assert code == 2
    assert said in err and err.count("\n") == 1
