"""A plant of one's own from the page of the documentation: run, verified, resumed, and refused where its code is not named."""

import json
import shutil
import subprocess

import numpy as np
import pytest

from plant.own_code import HAVE_RUN
from tests.tuner.experiments.own_motor import PLANT, STUDY, write_motor
from tests.tuner.in_process import called, tuner
from tuner.api import gains as tuner_api
from tuner.api import results as api
from tuner.documents.opening import open_results
from tuner.study.kinds import load_any

SHORT = ("--set", "search.generations=2", "--set", "scenario.0.held_out=8", "--set", "scenario.0.search=4")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A folder with the two files of the page."""
    folder = tmp_path_factory.mktemp("motor")
    write_motor(folder)
    return folder


@pytest.fixture(scope="module")
def run(written):
    """A short run of them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(written)
        code, _, err = called("run", "motor.toml", "--out", "r", *SHORT)
    assert code == 0, err
    return written / "r"


def test_the_run_recommends_what_keeps_the_limit_and_says_what_flew(run):
    results = open_results(run)
    assert results.document.required[0].tuned.value <= 2.0
    assert results.resolved.plant.name == "motor"
    assert [channel.law for channel in results.resolved.channel] == ["pid"]
    assert {fan.signal for fan in results.fans} == {"angle", "voltage"}
    assert {loop.channel for loop in results.loops} == {"angle"}
    assert results.gains_document.gains["angle.kp"].value > 0.0


def test_the_library_gives_its_points_as_values_by_address(run):
    results, written = api.open_results(run, kind=api.TuningResults), open_results(run)
    assert results.recommended == {address: entry.value for address, entry in written.gains_document.gains.items()}
    assert results.gains(written.tuned) == pytest.approx(results.recommended)
    assert results.default == written.resolved.gains
    # Every named point has its gains, the same as the file in points/; the best in an objective beats the default there.
    files = {name: tuner_api.read_gains(run / "points" / f"{name}.json") for name in results.points}
    assert {"least-itae.angle", "least-travel"} <= set(files) == {file.stem for file in (run / "points").iterdir()}
    for name, gains in results.points.items():
        assert dict(files[name]) == pytest.approx(dict(gains))
    assert results.points["least-itae.angle"] != results.default
    # A point's file belongs to the folder around it, whose run.json names the study.
    homes = {gains.folder for gains in files.values() if isinstance(gains, tuner_api.PlantGains)}
    assert homes == {results.home}


def test_a_point_can_be_chosen_by_what_is_limited(run):
    results = api.open_results(run, kind=api.TuningResults)
    front, units = results.front, results.front.attrs["units"]
    rows = {row.label: row for row in open_results(run).document.table}
    limit = rows["quantile50(rms.angle)@step"]
    assert np.all(front[limit.label] <= limit.limit)
    assert np.all(front[f"{limit.label} low"] <= front[f"{limit.label} high"])
    assert np.all(front["ms"] <= 2.0) and units["ms"] == "1" and units[limit.label] == "rad"
    ms = open_results(run).held_out_front.requirements
    assert results.finalists["ms"].tolist() == ms[:, 0].tolist()


def test_it_is_flown_again_to_the_same_bits(run, written, monkeypatch, capsys):
    code, out, err = tuner(monkeypatch, capsys, "verify", run, "--code", written / "motor.py")
    assert code == 0, err
    assert "every bit is the same" in out


def test_its_controller_is_c_with_the_bits_that_flew(run, written, monkeypatch, capsys, tmp_path):
    arguments = ("export", run / "gains.json", "--to", "c99", "--out", tmp_path / "c", "--code", written / "motor.py")
    code, out, err = tuner(monkeypatch, capsys, *arguments)
    assert code == 0, err
    assert "motor_controller.c" in out
    if shutil.which("make") and shutil.which("cc"):
        made = subprocess.run(["make"], cwd=tmp_path / "c", capture_output=True, text=True, check=True)
        assert "the same bits" in made.stdout
        assert "warning" not in made.stderr


@pytest.mark.usefixtures("few_golden_vectors")
def test_gains_outside_of_a_folder_are_exported_with_their_study(run, written, monkeypatch, capsys, tmp_path):
    file = tmp_path / "gains.json"
    file.write_bytes((run / "gains.json").read_bytes())
    arguments = ("export", file, "--to", "c99", "--flights", "2", "--out", tmp_path / "c")
    code, _, err = tuner(monkeypatch, capsys, *arguments)
    assert code == 2 and "or the study too" in err
    code, _, err = tuner(monkeypatch, capsys, *arguments, "--study", written / "motor.toml")
    assert code == 0 and (tmp_path / "c" / "motor_controller.c").exists(), err


def test_a_seed_beside_the_seed_of_a_study_is_refused(run, written, monkeypatch, capsys):
    for more in ((), ("--study", written / "motor.toml")):
        code, _, err = tuner(monkeypatch, capsys, "fly", run / "gains.json", "--seed", "99", *more)
        assert code == 2 and "given 99, and the study has a seed" in err


def test_gains_of_a_plant_are_refused_where_a_quadrotor_flies(run, monkeypatch, capsys):
    code, _, err = tuner(monkeypatch, capsys, "fly", run / "gains.json", "--study", "quickstart")
    assert code == 2
    assert "this is a study of a quadrotor, and the gains are those of a plant" in err and err.count("\n") == 1


def test_a_plant_flies_with_its_study_where_its_code_is_named(run, written, monkeypatch, capsys):
    assert tuner(monkeypatch, capsys, "fly", run / "gains.json", "--seeds", "4")[:1] == (2,)
    code, out, _ = tuner(
        monkeypatch, capsys, "fly", run / "gains.json", "--seeds", "4", "--code", written / "motor.py", "--json"
    )
    assert code == 0 and json.loads(out)["flights"] == 4


@pytest.mark.slow
def test_a_longer_budget_gives_what_the_longer_run_gives(run, written, monkeypatch, capsys, tmp_path):
    longer = tmp_path / "longer"
    shutil.copytree(run, longer)
    assert tuner(monkeypatch, capsys, "resume", longer, "--budget", "3", "--code", written / "motor.py")[0] == 0
    changes = [entry.replace("generations=2", "generations=3") for entry in SHORT]
    assert tuner(monkeypatch, capsys, "run", written / "motor.toml", "--out", tmp_path / "at_once", *changes)[0] == 0
    for name in ("front.csv", "gains.json", "generations/0002.npz"):
        assert (longer / name).read_bytes() == (tmp_path / "at_once" / name).read_bytes(), name


def test_a_results_folder_runs_no_code_that_nobody_named(run, monkeypatch, capsys):
    monkeypatch.setattr("plant.own_code.HAVE_RUN", {})
    code, _, err = tuner(monkeypatch, capsys, "verify", run)
    assert code == 2
    assert "--code" in err
    assert err.count("\n") == 1


def test_another_plant_of_the_same_name_is_refused(run, written, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("plant.own_code.HAVE_RUN", {})
    other = tmp_path / "motor.py"
    other.write_text(PLANT.replace("4.0", "5.0"), encoding="utf-8")
    code, _, err = tuner(monkeypatch, capsys, "verify", run, "--code", other)
    assert code == 2
    assert "changed since" in err


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('file = "motor.py"', 'file = "none.py"', "none.py: there is no such file"),
        ('law = "pid"', 'law = "pit"', "channel[0].law: unknown law 'pit'; did you mean 'pid'?"),
        ('output = "angle"', 'output = "angel"', "unknown output 'angel'; did you mean 'angle'?"),
        ('to = "voltage"', 'to = "volt"', "unknown input or channel 'volt'; did you mean 'voltage'?"),
        ("lost_beyond = 10.0", "# none", "lost_beyond = ..., the |error| from which on a flight has failed"),
        ("delay = 0.001", "delay = 0.0015", "a delay must be a whole number of control periods"),
        ("lag = 0.001", "lag = 0.0001", "a time constant of 0.0001 s, which would grow at such steps"),
        ("plant_step = 0.0005", "plant_step = 0.0003", "this must be a multiple of plant_step"),
        ('"angle.t_f" = 0.001', "", "gains.angle.t_f: is not given; write a number, or a range"),
        ("low = 0.05, high = 20.0,", "", "needs low and high"),
        ("default = 0.5", "default = 50.0", "outside its range of 0.05 to 20"),
        ("spread.inertia", "spread.inertai", "unknown spread 'inertai'; did you mean 'inertia'?"),
        ('kind = "step"', 'kind = "stepp"', "unknown signal 'stepp'; did you mean 'step'?"),
        (
            'reference.angle = { kind = "step", size = 1.0 }',
            'reference.angle = { kind = "coloured" }',
            "must not be random",
        ),
        (
            'kind = "step", size = 1.0',
            'kind = "step", size = -10.0',
            "reference.angle: it jumps by 10 within a control period, and a flight is lost from an error of 10 on",
        ),
        ("high = 12.0", "", "an input has no range"),
        ('metric = "itae.angle"', 'metric = "itae.roll"', "unknown metric address 'itae.roll'"),
        ('quantity = "ms"', 'quantity = "ms"\naxis = "roll"', "unknown channel 'roll'"),
        ('quantity = "ms"', 'quantity = "ms"\namplitude = -1.0', "margin[0].amplitude: given -1; allowed: 0 to 2"),
    ],
)
def test_what_does_not_fit_is_one_line_with_file_and_key(written, tmp_path, monkeypatch, capsys, old, new, said):
    assert old in STUDY
    shutil.copy(written / "motor.py", tmp_path)
    (tmp_path / "motor.toml").write_text(STUDY.replace(old, new, 1), encoding="utf-8")
    code, _, err = tuner(monkeypatch, capsys, "check", tmp_path / "motor.toml")
    assert code == 2
    assert said in err
    assert "motor.toml" in err or "none.py" in err
    assert err.count("\n") == 1


def test_a_channel_that_commands_itself_in_a_ring_is_refused(written, tmp_path):
    shutil.copy(written / "motor.py", tmp_path)
    ring = STUDY.replace('to = "voltage"', 'to = "inner"', 1).replace(
        "[gains]",
        '[[channel]]\nname = "inner"\nlaw = "pid"\noutput = "angle"\nto = "angle"\nlost_beyond = 1.0\n\n[gains]',
    )
    (tmp_path / "ring.toml").write_text(ring, encoding="utf-8")
    with pytest.raises(Exception, match="an algebraic loop: angle -> inner command each other in a ring"):
        load_any(tmp_path / "ring.toml")


@pytest.mark.slow
def test_a_cascade_of_two_rates_is_tuned_within_margins(written, tmp_path, monkeypatch, capsys):
    plant = PLANT.replace(
        '    angle: Annotated[float, "rad"]\n\n\ndef',
        '    angle: Annotated[float, "rad"]\n    speed: Annotated[float, "rad/s"]\n\n\ndef',
    )
    (tmp_path / "motor.py").write_text(plant.replace("Output(state.angle)", "Output(*state)"), encoding="utf-8")
    inner = (
        '[[channel]]\nname = "speed"\nlaw = "pid"\noutput = "speed"\nto = "voltage"\nlost_beyond = 1000.0\n\n[gains]\n'
    )
    inner += '"speed.kp" = { low = 0.02, high = 0.2, default = 0.05 }\n"speed.ki" = 0.5\n"speed.kd" = 0.0\n"speed.t_f" = 0.001'
    text = STUDY.replace('to = "voltage"', 'to = "speed"\nevery = 4').replace("[gains]", inner, 1)
    text = text.replace("low = 0.001, high = 0.5, default = 0.01", "low = 0.001, high = 0.1, default = 0.01")
    (tmp_path / "motor.toml").write_text(text, encoding="utf-8")
    code, _, err = tuner(monkeypatch, capsys, "run", tmp_path / "motor.toml", "--out", tmp_path / "r", *SHORT)
    assert code == 0, err
    results = open_results(tmp_path / "r")
    assert results.document.required[0].tuned.value <= 2.0
    assert {loop.channel for loop in results.loops} == {"angle", "speed"}


def test_the_same_code_is_run_once(written):
    before = len(HAVE_RUN)
    load_any(written / "motor.toml")
    load_any(written / "motor.toml")
    assert len(HAVE_RUN) <= before + 1


def test_check_tells_how_the_plant_is_stepped_and_how_far_its_margins_are_off(written, monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "check", written / "motor.toml")
    assert code == 0
    assert "2 steps of 0.5 ms a control period, fixed by the study; error up to 0." in out and "% of a margin (" in out
    lines = out.splitlines()
    assert [line.split()[0] for line in lines[:4]] == ["title", "plant", "channels", "variables"]
    assert any(line.startswith("Search: ") for line in lines) and any(
        line.startswith("Automatic limit") for line in lines
    )


def test_check_prints_the_limit_of_a_margin_beside_the_defaults_value(written, monkeypatch, capsys):
    study = written / "margins.toml"
    study.write_text((written / "motor.toml").read_text() + '\n[[margin]]\nquantity = "phase_margin"\nmin = 110\n')
    _, out, _ = tuner(monkeypatch, capsys, "check", study, "--json")
    values = json.loads(out)["requirements"]
    assert values["phase_margin"] < 110.0
    _, out, _ = tuner(monkeypatch, capsys, "check", study)
    (line,) = [line for line in out.splitlines() if line.startswith("requirements")]
    ms, phase = (f"{values[name]:.3g}" for name in ("ms", "phase_margin"))
    assert line.split(maxsplit=1)[1].strip() == (
        f"ms max 2 (default {ms}), phase_margin min 110 deg (default {phase} !)"
    )
