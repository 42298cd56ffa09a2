"""A run of a plant that no file holds: nothing advises to go on with it, and what would says why it cannot."""

import tomllib

import pytest

import tuner
from plant.errors import StoreError
from plant.own_code import run_own_code
from tests.tuner.experiments.own_motor import STUDY, write_motor
from tests.undrawn import undrawn
from tuner.store.advice import can_be_resumed, resume_hint
from tuner.store.folder import Folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    home = tmp_path_factory.mktemp("notebook")
    tables = tomllib.loads(STUDY)
    del tables["plant"]["file"], tables["margin"]
    tables["search"] = {"algorithm": "nsga2", "population": 8, "generations": 2, "racing": False}
    tables["scenario"][0] |= {"search": 4, "held_out": 16}
    names = run_own_code(write_motor(home).with_name("motor.py")).names
    with undrawn():
        tuner.run(tuner.make_study(tables, "motor", plant=names), out=home / "run", threads=2)
    return home / "run"


def test_its_report_advises_a_longer_search_but_no_resumption(folder):
    told = (folder / "summary.json").read_text(encoding="utf-8")
    assert "search.generations" in told and "tuner resume" not in told


def test_errors_about_its_folder_do_not_either(folder):
    assert not can_be_resumed(folder) and "resume" not in resume_hint(folder)
    with pytest.raises(StoreError) as told:
        Folder.create(folder)
    assert "resume" not in str(told.value)


@pytest.mark.parametrize("again", [tuner.resume, tuner.verify])
def test_who_tries_is_told_that_no_file_holds_it(folder, again):
    with pytest.raises(StoreError, match="no file holds the plant"):
        again(folder)
