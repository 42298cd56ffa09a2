"""`tuner export` and `tuner import` from end to end, as a person runs them."""

import json

import pytest

from tests.tuner.export.controllers import controller, pid
from tests.tuner.in_process import tuner
from tuner.export.writing import sha256
from tuner.gains_file import read_gains, to_document


@pytest.fixture
def run(monkeypatch, capsys):
    """Run a command and return exit code, standard output and standard error."""
    return lambda *arguments: tuner(monkeypatch, capsys, *arguments)


def written(folder, given, name="gains.json"):
    file = folder / name
    file.write_text(json.dumps(to_document(given, {})))
    return str(file)


@pytest.mark.parametrize(
    ("target", "options"), [("c99", ()), ("px4", ()), ("ardupilot", ("--firmware", "4.7")), ("matlab", ())]
)
def test_an_export_is_written_and_verified(run, tmp_path, target, options):
    gains = written(tmp_path, pid(period=0.002))
    out = tmp_path / "out"
    code, told, said = run("export", gains, "--to", target, *options, "--out", out, "--flights", "4", "--json")
    assert code == 0, said
    document = json.loads(told)
    assert document["target"] == target and document["verification"]["passed"]
    for name, digest in document["files"].items():
        assert sha256((out / name).read_bytes()) == digest
    assert all((out / "rollback" / name).exists() for name in document["rollback"])
    assert read_gains(out / "gains.json").gains == read_gains(tmp_path / "gains.json").gains


def test_the_table_names_what_is_lost(run, tmp_path):
    gains = written(tmp_path, pid(period=0.002))
    code, told, said = run("export", gains, "--to", "px4", "--out", tmp_path / "out", "--flights", "4")
    assert code == 0, said
    document = json.loads((tmp_path / "out" / "export.json").read_text())
    told = " ".join(told.split())
    assert document["lossy"] and all(" ".join(sentence.split()) in told for sentence in document["lossy"])
    assert "MC_ROLLRATE_P" in told


def test_a_hybrid_is_no_parameter_file(run, tmp_path):
    code, _, said = run("export", written(tmp_path, controller()), "--to", "px4", "--out", tmp_path / "out")
    assert code == 2
    assert "controller.attitude" in said and "c99" in said and len(said.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_firmware_is_asked_for(run, tmp_path):
    code, _, said = run("export", written(tmp_path, pid()), "--to", "ardupilot", "--out", tmp_path / "out")
    assert code == 2 and "--firmware" in said


def test_out_and_back_again(run, tmp_path):
    """What px4 holds is what an import of its file flies, up to the filter that the file has no place for."""
    gains = written(tmp_path, pid(period=0.004))
    out = tmp_path / "out"
    assert run("export", gains, "--to", "px4", "--out", out, "--flights", "2", "--json")[0] == 0
    (file,) = out.glob("*.params")
    back = tmp_path / "back.json"
    asked = ("import", file, "--from", "px4", "--airframe", "hummingbird", "--out", back)
    code, told, said = run(*asked, "--json")
    assert code == 0, said
    held = {row["gain"]: row["held"] for row in json.loads((out / "export.json").read_text())["verification"]["gains"]}
    found = json.loads(told)["gains"]
    for gain, value in held.items():
        if not gain.endswith("t_f"):
            assert found[gain]["value"] == pytest.approx(value, rel=1e-6), gain
    code, _, said = run(*asked)
    assert code == 2 and "not touched" in said
