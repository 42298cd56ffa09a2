"""`tuner compare-logs`: its answers as text and JSON, its prediction, its exit codes, and what it refuses in one line."""

import json
from pathlib import Path

import pytest

import tuner
from tests.tuner.in_process import called
from tuner.text.errors import BROKEN, USER_ERROR

LOG = Path(__file__).parents[1] / "logs" / "crazyflie" / "log15_70_to_85"
PAIR = (f"{LOG}@70:77", f"{LOG}@78:85", "--airframe", "crazyflie-pybullet")


def test_two_parts_of_a_flight_are_compared_with_intervals():
    code, said, _ = called("compare-logs", *PAIR, "--json")
    document = json.loads(said)
    assert code == 0 and document["flights"] == 0
    for row in document["measures"]:
        assert row["ratio"]["low"] <= row["ratio"]["value"] <= row["ratio"]["high"]
        assert row["ratio"]["value"] == pytest.approx(row["after"]["value"] / row["before"]["value"])
    assert called("compare-logs", *PAIR)[1].rstrip().endswith("in the same air.")


def test_a_prediction_that_is_not_kept_is_the_exit_code(tmp_path):
    """The quickstart's study is of another vehicle: so calm a flight is below, so noisy a one above what is predicted."""
    gains = tmp_path / "gains.json"
    tuner.default_gains("hybrid").write(gains)
    code, said, _ = called("compare-logs", *PAIR, "--gains", gains, "--study", "quickstart", "--json")
    document = json.loads(said)
    rows = {row["name"]: row for row in document["measures"]}
    kept = [rows[name]["after"]["low"] <= rows[name]["predicted"] for name in ("noise", "travel")]
    assert document["flights"] == 256 and [rows[name]["kept"] for name in ("noise", "travel")] == kept
    assert code == (0 if all(kept) else BROKEN) and rows["lift"]["predicted"] is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([*PAIR[:1], *PAIR[:1], *PAIR[2:]], "is given twice"),
        ([f"{LOG}@70:75", *PAIR[1:]], "at least 6 s are compared"),
        ([*PAIR, "--study", "quickstart"], "give both, or neither"),
        (["no_such_log", *PAIR[1:]], "there is no such file"),
    ],
)
def test_what_cannot_be_compared_is_told_in_a_line(arguments, message):
    code, _, told = called("compare-logs", *arguments)
    assert code == USER_ERROR and message in told and len(told.strip().splitlines()) == 1
