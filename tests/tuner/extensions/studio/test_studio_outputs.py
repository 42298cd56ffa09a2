"""Files that leave the page: those of the commands, in the folder of the studio alone."""

import pytest

import tuner
from tuner.extensions.studio.messages import read_request
from tuner.extensions.studio.outputs import Outputs
from tuner.study.plant_study import PlantStudy

VALUES = {"angle.kp": 8.0, "angle.ki": 12.0, "angle.kd": 0.12}


@pytest.fixture
def page_request(bench):
    return read_request(
        bench.session, ["angle"], {"number": 1, "values": VALUES, "pins": [{"name": "a/b", "values": {}}]}
    )


def test_a_study_of_the_setting_has_it_as_default(bench, page_request, tmp_path):
    outputs = Outputs(bench, tmp_path)
    assert "tuner run" in outputs.study(page_request, {"file": "mine.toml"})["text"]
    study = tuner.load_study(tmp_path / "mine.toml", kind=PlantStudy)
    assert tuner.read_gains(tmp_path / "mine.toml")["angle.kp"] == 8.0
    # All but the default is the study that was opened.
    before = bench.session.study
    assert [(v.low, v.high, v.scale) for v in study.space.variables] == [
        (v.low, v.high, v.scale) for v in before.space.variables
    ]
    assert study.objectives == before.objectives and study.scenarios == before.scenarios


def test_an_export_is_that_of_the_command(bench, page_request, tmp_path, few_golden_vectors, monkeypatch):
    monkeypatch.setattr("tuner.extensions.studio.outputs.EXPORT_FLIGHTS", 2)
    answer = Outputs(bench, tmp_path).export(page_request, {"target": "c99", "folder": "code"})
    assert "rounding breaks no limit" in answer["text"] and (tmp_path / "code" / "export.json").exists()


def test_targets_of_quadrotors_are_not_offered_and_refused_for_a_plant(bench, page_request, tmp_path):
    outputs = Outputs(bench, tmp_path)
    assert "c99" in outputs.offers["targets"] and "px4" not in outputs.offers["targets"]
    with pytest.raises(Exception, match="takes the loops of a quadrotor"):
        outputs.export(page_request, {"target": "px4", "folder": "px4"})
    assert not (tmp_path / "px4").exists()


def test_without_a_present_file_nothing_is_judged(bench, page_request, tmp_path):
    outputs = Outputs(bench, tmp_path)
    assert outputs.offers["judges"] is False
    with pytest.raises(Exception, match="--present FILE"):
        outputs.judge(page_request, {"folder": "opinion"})


def test_new_flights_compare_as_the_command_does(bench, page_request, tmp_path, monkeypatch):
    monkeypatch.setattr("tuner.extensions.studio.outputs.COMPARED_FLIGHTS", 16)
    answer = Outputs(bench, tmp_path).compare(page_request, {})
    gains = tuner.read_gains(bench.session.study.path)
    files = [gains.write(tmp_path / "default.json"), gains.replace(VALUES).write(tmp_path / "here.json")]
    document = tuner.compare(files, study=bench.session.study, flights=16).document
    row = next(each for each in document.differences if each.quantity == "mean(travel)")
    line = next(each for each in answer["lines"] if each.startswith("mean(travel): here − default"))
    value, ends = line.removeprefix("mean(travel): here − default = ").replace("−", "-").split(" ", 1)
    half = 0.5 * 10.0 ** -len(value.partition(".")[2])
    assert float(value) == pytest.approx(row.estimate.value, abs=half) and ends.startswith("[")
    assert any("a-b" in each for each in answer["lines"])
