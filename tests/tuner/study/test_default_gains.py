"""[controller] default: gains of a vehicle stand in for the laws' defaults, and travel with the run."""

import json
import re
from math import radians
from pathlib import Path

import pytest

from plant.errors import InputError
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.nominal import ControlOptions
from tests.tuner.exchange.controllers import controller
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.gains import to_document
from tuner.study.build import load_study

QUICKSTART = Path(__file__).parents[3] / "studies" / "quickstart.toml"


def study(folder, given, line='default = "vehicle.json"'):
    (folder / "vehicle.json").write_text(json.dumps(to_document(given, {})))
    text = re.sub(r'(attitude = "hybrid".*)', rf"\1\n{line}", QUICKSTART.read_text(), count=1)
    (folder / "study.toml").write_text(text)
    return folder / "study.toml"


def test_the_file_gives_the_default_row(tmp_path):
    given = controller(roll__k2=7.5, x__zeta=0.9)
    found = load_study(study(tmp_path, given))
    plain = load_study(QUICKSTART)
    fixed = {c for c in range(len(given.gains)) if plain.default_row[c] != controller().gains[c]}
    for gain in gain_addresses(given.cascade):
        if gain.column not in fixed:
            assert found.default_row[gain.column] == given.gains[gain.column], gain.address
    assert found.digest() != plain.digest()


def test_laws_must_be_those_of_the_study(tmp_path):
    with pytest.raises(InputError, match=r"controller\.default.*holds the attitude law 'ladrc'"):
        load_study(study(tmp_path, controller(attitude="ladrc")))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"controller\.default.*nowhere\.json"):
        load_study(study(tmp_path, controller(), 'default = "nowhere.json"'))


def test_the_place_of_the_file_does_not_count(tmp_path):
    """The same gains under another name are the same study."""
    first = load_study(study(tmp_path, controller(roll__k2=7.5))).digest()
    other = tmp_path / "other"
    other.mkdir()
    file = study(other, controller(roll__k2=7.5), 'default = "again.json"')
    (other / "vehicle.json").rename(other / "again.json")
    assert load_study(file).digest() == first


def test_gains_of_another_vehicle_are_told(tmp_path):
    flown = {"period": 0.004, "options": ControlOptions(delay=True, tilt_limit=radians(30.0))}
    assert warnings_before_run(load_study(study(tmp_path, controller(**flown)))) == []
    other = load_study(study(tmp_path, controller(airframe="iris", period=0.002, options=ControlOptions(delay=False))))
    (said,) = warnings_before_run(other)
    for words in (
        "airframe 'iris' instead of 'hummingbird'",
        "control_period [s] 0.002 instead of 0.004",
        "delay False instead of True",
    ):
        assert words in said
    assert "plant_step" not in said


def test_one_value_for_several_is_told(tmp_path):
    given = controller(options=ControlOptions(delay=True, tilt_limit=radians(30.0)), yaw__k2=2.0)
    (said,) = warnings_before_run(load_study(study(tmp_path, given)))
    assert "attitude.k2 (5, 5, 2)" in said and '"yaw.k2" = {}' in said
