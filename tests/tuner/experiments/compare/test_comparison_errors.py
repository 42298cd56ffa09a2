"""What cannot be compared is refused before a flight, with the argument named."""

import shutil

import pytest

from tests.tuner.conftest import QUICKSTART
from tests.tuner.experiments.compare.conftest import changed_gains
from tests.tuner.extensions.contests.experiments.contest_text import write
from tests.tuner.extensions.contests.report.fabricate_contest import Made, fabricate
from tests.tuner.in_process import tuner
from tuner import compare
from tuner.experiments.compare.entrants import names_of


@pytest.fixture
def refused(monkeypatch, capsys):
    def run(*arguments):
        code, out, err = tuner(monkeypatch, capsys, "compare", *arguments)
        assert code == 2 and out == "" and "Traceback" not in err
        return " ".join(err.split())

    return run


def test_one_is_not_enough(refused, paths):
    assert "at least two" in refused(paths[0])


def test_the_same_twice(refused, paths):
    message = refused(paths[0], paths[1], paths[0] / ".." / paths[0].name)
    assert "given twice" in message


def test_gains_alone_need_a_study(refused, paths):
    assert "--study" in refused(paths[1], paths[2])


def test_what_is_not_there(refused, paths, tmp_path):
    missing = tmp_path / "nowhere.json"
    assert str(missing) in refused(paths[0], missing)


def test_the_folder_of_a_contest(refused, paths, tmp_path):
    folder = fabricate(tmp_path / "contest", Made())
    message = refused(paths[0], folder)
    assert str(folder) in message and "contest" in message


def test_a_run_that_is_not_finished(refused, paths, tmp_path):
    stopped = tmp_path / "stopped"
    shutil.copytree(paths[0], stopped)
    (stopped / "summary.json").unlink()
    assert f"tuner resume {stopped}" in refused(paths[0], stopped)


def test_another_control_period(refused, paths, tmp_path):
    other = changed_gains(paths[1], tmp_path / "slow.json", control_period={"value": 0.002, "unit": "s"})
    message = refused(paths[0], other)
    assert (
        str(other) in message and "controller.control_period" in message and "0.002" in message and "0.004" in message
    )


def test_a_contest_is_no_study_to_fly(refused, paths, tmp_path):
    path = write(tmp_path)
    assert str(path) in refused(paths[0], paths[1], "--study", path)


def test_an_existing_folder_is_kept(refused, paths, tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "mine.txt").write_text("mine")
    assert "exists already" in refused(paths[0], paths[1], "--out", tmp_path / "there", "--seeds", 2)
    assert [file.name for file in (tmp_path / "there").iterdir()] == ["mine.txt"]


def test_gains_files_fly_the_scenarios_of_a_study(paths, monkeypatch, capsys):
    code, out, err = tuner(monkeypatch, capsys, "compare", paths[1], paths[2], "--study", QUICKSTART, "--seeds", 2)
    assert code == 0, err
    assert "Quickstart" in out


def test_a_study_and_results_of_its_name_are_told_apart(paths, tmp_path):
    study, file = tmp_path / "same.toml", tmp_path / "same" / "gains.json"
    file.parent.mkdir()
    shutil.copy(paths[1], file)
    shutil.copy(QUICKSTART, study)
    both = compare([study, file], study=QUICKSTART, flights=2).document.contenders
    assert [entry.name for entry in both] == [str(study), str(file)]
    others = compare([study, paths[2]], study=QUICKSTART, flights=2).document.contenders
    assert [entry.name for entry in others] == ["same", "softer"]


def test_namesakes_are_told_apart_by_their_paths(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name / "run").mkdir(parents=True)
    one, two = tmp_path / "a" / "run", tmp_path / "b" / "run"
    assert names_of([one, two]) == [str(one), str(two)]
    assert names_of([one, tmp_path / "b" / "gains.json", tmp_path / "stiff.json"]) == ["run", "b", "stiff"]
