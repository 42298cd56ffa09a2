"""`tuner new` with a parts list: the airframe as a file that a study flies, as text and JSON, and what it refuses in one line."""

import json

import pytest
from typer.main import get_command

from plant.quadrotor.airframes import load
from plant.quadrotor.scenarios import SEARCH, sample_scenarios
from tests.tuner.in_process import called
from tests.tuner.study.study_text import changed
from tuner.cli.main import app
from tuner.study.build import load_study
from tuner.text.errors import USER_ERROR

PARTS = {"--mass": "1.4", "--wheelbase": "0.45", "--propeller": "10x4.5", "--kv": "920", "--cells": "3"}


def options(parts):
    return [text for pair in parts.items() for text in pair]


def test_a_parts_list_becomes_an_airframe_that_a_study_flies(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, said, _ = called("new", "airframe", *options(PARTS), "--json")
    document = json.loads(said)
    assert code == 0 and document["file"] == "airframe.toml"
    airframe = load(tmp_path / "airframe.toml")
    assert airframe.sources["inertia.x"].source.startswith("estimated")
    assert airframe.uncertainty is not None and [row["name"] for row in document["numbers"]] == list(
        airframe.uncertainty.names
    )
    text = changed('name = "hummingbird"', 'file = "airframe.toml"', changed("mass = 0.1", 'from = "airframe"'))
    (tmp_path / "study.toml").write_text(text)
    study = load_study(tmp_path / "study.toml")
    drawn = sample_scenarios(study.scenarios[0].spec, study.system.vehicle, study.system.timing, 1, SEARCH, range(8))
    assert drawn.count == 8


# A whoop of 31 mm propellers and a heavy lifter of 457 mm; lags of both scale with the root of the diameter.
WHOOP = {"--mass": "0.019", "--wheelbase": "0.065", "--propeller": "1.2x0.8", "--kv": "19000", "--cells": "1"}
LIFTER = {"--mass": "5.5", "--wheelbase": "0.9", "--propeller": "18x6", "--kv": "380", "--cells": "6"}


def test_what_it_writes_of_small_and_large_ones_is_an_airframe(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lags = []
    for name, parts in (("whoop", WHOOP), ("lifter", LIFTER)):
        code, _, _ = called("new", name, *options(parts))
        assert code == 0 and called("check", f"{name}.toml")[0] == 0
        lags.append(load(tmp_path / f"{name}.toml").vehicle.lag_up)
    assert 0.01 < lags[0] < 0.02 < 0.04 < lags[1] < 0.08
    assert lags[1] / lags[0] == pytest.approx((18.0 / 1.2) ** 0.5, rel=0.01)


def test_the_ranges_are_printed_with_what_to_do_next(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, said, _ = called("new", "mine", *options(PARTS), "--hover", "0.55")
    assert code == 0 and "thrust_coefficient" in said and "tuner identify LOG" in said


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"--mass": "1.4"}, "add --wheelbase --propeller --kv --cells"),
        (PARTS | {"--mass": "nan"}, "allowed: 0.01 to 50"),
        (PARTS | {"--mass": "30"}, "would lift"),
        (PARTS | {"--propeller": "10"}, "write diameter and pitch in inches"),
        (PARTS | {"--propeller": "10x45"}, "of the diameter as pitch"),
        (PARTS | {"--propeller": "10x4.5x9"}, "given 9 blades; allowed: 2 to 6"),
        (PARTS | {"--cells": "0"}, "given 0 cells"),
        (PARTS | {"--hover": "1.2"}, "given 1.2 of full command"),
        (PARTS | {"--from": "f450"}, "leave either out"),
    ],
)
def test_what_cannot_be_estimated_is_told_in_a_line(parts, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, told = called("new", "mine", *options(parts))
    assert code == USER_ERROR and message in told and len(told.strip().splitlines()) == 1
    assert not (tmp_path / "mine.toml").exists()


def test_a_new_study_is_told_as_json_too(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, said, _ = called("new", "mine", "--json")
    assert code == 0 and json.loads(said) == {"written": ["mine.toml"]}


def test_a_study_goes_where_out_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for out, path in (("there", "there/mine.toml"), ("here/own.toml", "here/own.toml")):
        code, said, _ = called("new", "mine", "--out", out)
        assert code == 0 and path in said and (tmp_path / path).exists()
    code, _, err = called("new", "mine", "--out", "there")
    assert code == USER_ERROR and "exists already" in err


@pytest.mark.parametrize("words", [("new", "mine", "--out"), ("run", "quickstart", "--out"), ("fly", "--law")])
def test_an_option_without_its_value_is_told_what_it_takes(words):
    code, _, err = called(*words)
    option = next(param for param in vars(get_command(app))["commands"][words[0]].params if words[-1] in param.opts)
    assert code == USER_ERROR and f"'{words[-1]}' requires an argument. {option.help}" in " ".join(err.split())
