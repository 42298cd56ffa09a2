"""`tuner theory` and `tuner list theorems`, as a user meets them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from plant.law_registry import LAWS
from plant.laws.hybrid import Gains
from plant.quadrotor.cascade import AXES, close_cascade
from plant.quadrotor.gains import gain_addresses
from tests.tuner.cli.test_cli import refused
from tuner.extensions.theory.api import theory_rows
from tuner.extensions.theory.theorems import THEOREMS, Setting
from tuner.gains import read_gains

STUDY = "studies/quickstart.toml"


@pytest.fixture(scope="module")
def gains(small_run):
    _, folder = small_run
    return folder / "gains.json"


def test_every_axis_and_theorem_with_the_rate_measured_in_the_study(gains, tuner):
    answer = json.loads(tuner("theory", gains, "--study", STUDY, "--json").stdout)
    assert (answer["scenarios"], answer["level"]) == (["steps in gusts"], 0.99)
    by_axis = {axis: [row["theorem"] for row in answer["theorems"] if row["axis"] == axis] for axis in answer["axes"]}
    observer = ["observer_value", "observer_rate", "observer_disturbance"]
    assert by_axis == dict.fromkeys("xyz", observer) | dict.fromkeys(
        ("roll", "pitch", "yaw"), [*observer, "ultimate_error"]
    )
    row = next(row for row in answer["theorems"] if (row["axis"], row["theorem"]) == ("pitch", "ultimate_error"))
    document = json.loads(gains.read_text())["gains"]
    found = [document[f"pitch.{name}"]["value"] for name in ("omega_o", "lambda", "k1", "k2", "delta")]
    setting = Setting(0.004, answer["rates"]["pitch"])
    expected = THEOREMS["ultimate_error"].values["hybrid"](Gains(*np.array(found)), setting)
    assert row["value"] == pytest.approx(float(expected), rel=1e-12)
    assert (row["unit"], row["rate_unit"], row["holds"], row["law"]) == ("rad", "rad/s^3", None, "hybrid")
    assert row["disturbance_rate"] == answer["rates"]["pitch"] > 0.0


def test_the_table_says_what_is_assumed(gains, tuner):
    shown = tuner("theory", gains).stdout
    assert "steps in a fresh breeze" in " ".join(shown.split())
    assert "ultimate_error" in shown and "rad/s^3" in shown and "Assumes" in shown


def test_a_rate_that_is_borne_holds_or_does_not(gains):
    # k1 = 10, k2 = 40 on each axis of attitude: Seeber and Horn's condition gives 40.
    cascade = close_cascade(LAWS["pid"], LAWS["supertwisting"])
    chosen = {"lambda_": 5.0, "k1": 10.0, "k2": 40.0}
    row = tuple(chosen.get(gain.info.name, gain.default) for gain in gain_addresses(cascade))
    controller = replace(read_gains(gains), cascade=cascade, gains=row)
    rates = dict.fromkeys(AXES, 39.0) | {"yaw": 41.0}
    rows = theory_rows(controller, rates)
    assert {row.axis for row in rows} == {"roll", "pitch", "yaw"}
    holds = {row.axis: row.holds for row in rows if row.theorem == "sta_seeber_horn"}
    assert holds == {"roll": True, "pitch": True, "yaw": False}


def test_help_and_errors(tuner):
    done = tuner("theory", "--help")
    assert done.returncode == 0 and "Example: tuner theory" in " ".join(done.stdout.split())
    assert "there is no such file" in refused(tuner("theory", "nowhere.json"))


def test_theorems_are_listed(tuner):
    rows = json.loads(tuner("list", "theorems", "--json").stdout)
    assert [row["theorem"] for row in rows] == list(THEOREMS)
    shown = tuner("list", "theorems").stdout
    assert "ultimate_error" in shown and "rad|m" in shown
