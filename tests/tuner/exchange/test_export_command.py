"""`tuner export` and `tuner import` from end to end, as a person runs them."""

import json
from dataclasses import replace
from math import radians

import pytest

from tests.tuner.exchange.controllers import controller, pid
from tests.tuner.in_process import tuner
from tuner.cli.printers.export import said_of_margins
from tuner.documents.export import RoundedMargin, VerificationPart
from tuner.gains import read_gains, to_document
from tuner.store.manifest import digest_of


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
        assert digest_of((out / name).read_bytes()) == digest
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


def test_an_import_is_compared_with_the_vehicle_at_the_export(run, tmp_path):
    """The table names old, new and change; what nothing tuned carries is kept; the same for a program."""
    params = tmp_path / "quad.params"
    params.write_text("1\t1\tMC_ROLLRATE_P\t0.15\t9\n1\t1\tMC_ROLLRATE_D\t0.003\t9\n1\t1\tTHR_MDL_FAC\t0.3\t9\n")
    back = tmp_path / "vehicle.json"
    code, told, said = run("import", params, "--from", "px4", "--airframe", "iris", "--out", back, "--json")
    assert code == 0, said
    found = json.loads(told)
    assert found["vehicle"]["kept"] == ["MC_ROLLRATE_D", "THR_MDL_FAC"] and found["vehicle"]["file"] == "quad.params"
    code, told, said = run("validate", back)
    assert code == 0, said
    asked = ("export", back, "--to", "px4", "--flights", "2")
    code, told, said = run(*asked, "--out", tmp_path / "one")
    assert code == 0, said
    told = " ".join(told.split())
    assert "vehicle new change" in told and "Give --previous if the vehicle has changed since" in told
    now = tmp_path / "now.params"
    now.write_text(params.read_text().replace("0.15", "0.12"))
    code, told, said = run(*asked, "--out", tmp_path / "two", "--previous", now, "--json")
    assert code == 0, said
    rows = {row["name"]: row for row in json.loads(told)["parameters"]}
    assert rows["MC_ROLLRATE_P"]["before"] == pytest.approx(0.12) and rows["MC_ROLLRATE_P"]["change"] == pytest.approx(
        0.03
    )
    assert rows["MC_ROLLRATE_D"]["kept"] and rows["MC_ROLLRATE_D"]["change"] == 0.0
    assert rows["MPC_XY_P"]["before"] is None and rows["MPC_XY_P"]["change"] is None


@pytest.mark.usefixtures("unflown")
def test_parameters_that_a_file_lacks_stand_at_their_defaults(run, tmp_path):
    """They are compared with the default; what changes beside the gains comes first of the sentences."""
    params = tmp_path / "quad.params"
    params.write_text("1\t1\tMC_ROLLRATE_P\t0.12\t9\n1\t1\tTHR_MDL_FAC\t1\t9\n")
    back = tmp_path / "vehicle.json"
    own = ("--airframe", "iris", "--set", "loops=own", "--out", back)
    assert run("import", params, "--from", "px4", *own)[0] == 0
    given = read_gains(back)
    options = replace(given.options, tilt_limit=radians(30.0), yaw_torque_cutoff=0.57)
    document = to_document(replace(given, options=options), {})
    back.write_text(json.dumps(document))
    code, told, said = run(
        "export", back, "--to", "px4", "--previous", params, "--flights", "2", "--out", tmp_path / "out"
    )
    assert code == 0, said
    rows = {row.split()[0]: row for row in told.splitlines() if row.startswith(("MC_", "MPC_", "IMU_"))}
    assert "3 (default)" not in rows["MC_ROLLRATE_P"] and "same" in rows["MC_ROLLRATE_P"]
    assert "0.3 (default)" in rows["MC_RR_INT_LIM"] and "same" in rows["MC_RR_INT_LIM"]
    assert "45 (default)" in rows["MPC_TILTMAX_AIR"] and "-33 %" in rows["MPC_TILTMAX_AIR"]
    assert "quad.params: 2 of 34 parameters change." in " ".join(told.split())
    (first, *_) = [row for row in told.splitlines() if row.startswith("- ")]
    assert "MC_YAW_TQ_CUTOFF 2 (default) to 0.57 Hz, MPC_TILTMAX_AIR 45 (default) to 30 deg" in first


@pytest.mark.usefixtures("unflown")
def test_betaflight_is_compared_with_the_vehicle(run, tmp_path):
    diff = tmp_path / "diff.txt"
    diff.write_text("set p_pitch = 58\nset d_max_roll = 48\n")
    back = tmp_path / "vehicle.json"
    own = ("--airframe", "racer5", "--set", "loops=own", "--out", back)
    assert run("import", diff, "--from", "betaflight", *own)[0] == 0
    code, told, said = run(
        "export", back, "--to", "betaflight", "--previous", diff, "--flights", "2", "--out", tmp_path / "out"
    )
    assert code == 0, said
    told = " ".join(told.split())
    for words in (
        "d_max_roll 48 0 -100 %",
        "p_pitch 58 58 same",
        "p_roll 45 (default) 45 same",
        "previous file diff.txt",
    ):
        assert words in told, words


@pytest.mark.parametrize(
    ("differing", "words"), [(0, "none changes"), (1, "1 of them changes"), (2, "2 of them change")]
)
def test_margins_that_change_are_counted(differing, words):
    rows = [
        RoundedMargin(
            label="", quantity=None, unit="", limit=1.0, sense="min", asked=2.0, held=2.0 + (k < differing),
            kept_asked=True, kept_held=True,
        )
        for k in range(3)
    ]  # fmt: skip
    verification = VerificationPart.model_construct(margins=rows)
    said = said_of_margins(verification, "at rest")
    assert f"{words} in five digits" in said and "limits on margins at rest;" in said


def test_a_hostile_file_name_stays_one_line(run, tmp_path):
    params = tmp_path / "quad\n1\t1\tCOM_ARM\t0.params"
    params.write_text("1\t1\tMC_ROLLRATE_P\t0.15\t9\n")
    back = tmp_path / "vehicle.json"
    assert run("import", params, "--from", "px4", "--airframe", "iris", "--out", back, "--json")[0] == 0
    out = tmp_path / "out"
    assert run("export", back, "--to", "px4", "--flights", "2", "--out", out, "--previous", params, "--json")[0] == 0
    for file in (*out.glob("*.params"), *(out / "rollback").glob("*.params")):
        assert not any(line.startswith("1\t1\tCOM_ARM") for line in file.read_text().splitlines())
