"""`tuner identify`: its answers as text and JSON, its exit codes, and what it refuses in one line."""

import json
from pathlib import Path

import pytest

from plant.quadrotor.airframes import load
from tests.tuner.extensions.logs.written import crazyflie, truth
from tests.tuner.in_process import called
from tuner.extensions.flight_plans import limits
from tuner.extensions.vehicle_fit import fit
from tuner.text.errors import BROKEN, USER_ERROR

LOG = Path(__file__).parents[1] / "logs" / "crazyflie" / "log15_70_to_85"
PRIOR = ("--airframe", "crazyflie-pybullet")


def test_a_flight_becomes_an_airframe_and_a_document(tmp_path, monkeypatch):
    # Each further fit of the noise takes as long again, and moves no verdict here.
    monkeypatch.setattr(fit, "MAX_NOISE_FITS", 1)
    out = tmp_path / "mine.toml"
    page = tmp_path / "mine.html"
    code, said, _ = called("identify", f"{LOG}@71:80", *PRIOR, "--out", str(out), "--report", page, "--json")
    document = json.loads(said)
    assert code == 0 and document["verdict"] in page.read_text()
    assert document["file"] == str(out) and document["logs"][0]["begin"] >= 71.0
    uncertainty = load(out).uncertainty
    assert uncertainty is not None and list(uncertainty.names) == document["uncertainty"]
    numbers = {row["name"]: row for row in document["numbers"]}
    assert numbers["lag_up"]["identified"] and not numbers["mass"]["identified"]
    # In nine seconds of hardly any climb the weight tells the thrust at the mean command, 0.67, and no other.
    assert numbers["thrust.65"]["identified"] and not numbers["thrust.30"]["identified"]
    assert "of the prior's" in numbers["thrust.30"]["reason"]
    for row in (row for row in document["numbers"] if row["identified"] and row["prior_low"] > 0.0):
        assert row["high"] / row["low"] < row["prior_high"] / row["prior_low"], row


def test_a_second_log_narrows_the_first_and_is_not_counted_twice(tmp_path, monkeypatch):
    # Fitted less closely: what counts here is the way from one document to the next.
    monkeypatch.setattr(fit, "MAX_NOISE_FITS", 1)
    first, bad = tmp_path / "first.json", tmp_path / "bad.json"
    first.write_text(called("identify", f"{LOG}@70:77", *PRIOR, "--json")[1])
    code, said, _ = called("identify", f"{LOG}@78:85", *PRIOR, "--update", first, "--json")
    document, before = json.loads(said), json.loads(first.read_text())
    assert code == 0 and document["before"] == before["logs"]
    width = [
        {r["name"]: r["high"] / r["low"] for r in found["numbers"] if r["low"] > 0.0} for found in (before, document)
    ]
    assert width[1]["lag_up"] < width[0]["lag_up"]
    bad.write_text('{"posterior": 1}')
    spoilt = json.loads(first.read_text())
    spoilt["posterior"]["covariance"][0][1] = 1.0
    (tmp_path / "spoilt.json").write_text(json.dumps(spoilt))
    for arguments, message in (
        ([f"{LOG}@75:80", *PRIOR, "--update", first], "would count twice"),
        ([f"{LOG}@78:85", "--airframe", "f450", "--update", first], "with the same airframe"),
        ([f"{LOG}@78:85", *PRIOR, "--update", bad], "is not what `tuner identify --json` prints"),
        ([f"{LOG}@78:85", *PRIOR, "--update", tmp_path / "spoilt.json"], "identify the first log again"),
        ([f"{LOG}@78:85", *PRIOR, "--update", first, "--mass", "0.03"], "leave --mass and --arm out"),
    ):
        code, _, told = called("identify", *arguments)
        assert code == USER_ERROR and message in told and len(told.strip().splitlines()) == 1


def test_a_check_tells_what_it_read_and_that_it_can_be_used():
    code, said, _ = called("identify", LOG, *PRIOR, "--check")
    assert code == 0 and "Crazyflie SD card" in " ".join(said.split()) and "The logs can be used." in said


def test_a_check_that_fails_says_so_by_its_exit_code(tmp_path):
    made = truth(6000)
    file = tmp_path / "log"
    file.write_bytes(crazyflie(made._replace(acceleration=-made.acceleration)))
    code, said, _ = called("identify", file, *PRIOR, "--check", "--json")
    assert code == BROKEN and not json.loads(said)["usable"]
    code, _, told = called("identify", file, *PRIOR)
    assert code == USER_ERROR and "z points down" in told and "--force" in told


@pytest.fixture
def compiled_laws(monkeypatch):
    """Fly plans by laws that other tests compile."""
    monkeypatch.setattr("tuner.extensions.flight_plans.api.LAW", "hybrid")


def test_a_limit_without_an_option_is_not_to_be_raised(compiled_laws, monkeypatch):
    monkeypatch.setattr(limits, "MOTOR_RANGE", 1e-4)
    _, _, message = called("identify", "--plan", "f450")
    assert "air and noise alone take the motors to" in message and "(--gains)" in message
    assert "raise" not in message and "allow more" not in message


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["no_such_log", *PRIOR], "there is no such file"),
        ([str(LOG), str(LOG), *PRIOR], "is given twice"),
        ([f"{LOG}@70:78", f"{LOG}@75:85", *PRIOR], "in parts that overlap"),
        ([f"{LOG}@1:2", *PRIOR], "it goes from 70.0 to 85.0 s"),
        ([str(LOG), *PRIOR, "--out", "mine.json"], "ends in .toml"),
        ([str(LOG), *PRIOR, "--out", "no_folder/mine.toml"], "make it first"),
        ([str(LOG), *PRIOR, "--report", "mine.pdf"], "ends in .html"),
        ([str(LOG), *PRIOR, "--mass", "2"], "up to 0.5"),
        ([str(LOG), "--airframe", "crazyfly"], "unknown airframe"),
    ],
)
def test_what_cannot_be_used_is_told_in_a_line(arguments, message):
    code, _, told = called("identify", *arguments)
    assert code == USER_ERROR
    assert message in told and len(told.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([LOG, "--plan", "f450"], "remove LOG and its options"),
        (["--airframe", "f450", "--plan", "f450"], "remove LOG and its options"),
        ([LOG, *PRIOR, "--numbers", "lag_up"], "belong to a plan; give --plan AIRFRAME"),
        ([LOG], "give a log and --airframe, or --plan AIRFRAME"),
        (["--airframe", "f450"], "give a log and --airframe, or --plan AIRFRAME"),
        (["--plan", "f45"], "unknown airframe"),
        (["--plan", "paper-literal"], "no real airframe has these numbers"),
        (["--plan", "f450", "--within", "much"], "give a share, 5% or 0.05"),
        (["--plan", "f450", "--within", "200%"], "allowed: 0.001 to 1"),
        (["--plan", "f450", "--tilt", "90"], "allowed: 1 to 60"),
        (["--plan", "f450", "--arm", "0"], "up to 0.5"),
        (["--plan", "f450", "--to", "px4"], "MC_AT_SYSID_AMP"),
        (["--plan", "f450", "--numbers", "arm"], "which no flight identifies"),
        (["--plan", "f450", "--numbers", "lag"], "unknown parameter that a flight identifies 'lag'"),
        (["--plan", "f450", "--tilt", "1", "--rate", "5"], "air and noise alone take the rate to"),
        (["--plan", "f450", "--report", "plan.pdf"], "ends in .html"),
    ],
)
def test_what_cannot_be_planned_is_told_in_a_line(arguments, message, compiled_laws):
    code, _, told = called("identify", *arguments)
    assert code == USER_ERROR and message in told
    assert len([line for line in told.strip().splitlines() if not line.startswith("Planning")]) == 1
