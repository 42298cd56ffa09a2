"""A run with a law, metrics and a reference of one's own, from the study to C, and again from its folder."""

import shutil
import subprocess
from pathlib import Path

import pytest

import tuner
from plant.errors import InputError, UnnamedCodeError
from tests.plant.own_files import LAW, METRIC, REFERENCE, SWAY, forget
from tuner.study.files import SHIPPED

SMALL = {"search.generations": 2, "search.population": 8, "scenario.0.held_out": 32}


@pytest.mark.slow
def test_from_the_study_to_c_and_again_from_the_folder(tmp_path: Path) -> None:
    shutil.copy(SHIPPED / "own_law.toml", tmp_path)
    shutil.copytree(LAW.parent, tmp_path / "own_law")
    results = tmp_path / "results"
    tuner.run(tuner.load_study(tmp_path / "own_law.toml", SMALL), results)
    forget()
    with pytest.raises(UnnamedCodeError):
        tuner.verify(results)
    gains = results / "gains.json"
    with pytest.raises(InputError, match="name the file with --code pid_plain.py"):
        tuner.export(gains, "c99", tmp_path / "refused")
    tuner.open_results(results).report()
    for file in (LAW, METRIC, SWAY, REFERENCE):
        tuner.use(file)
    assert tuner.verify(results).identical
    tuner.export(gains, "c99", tmp_path / "c99")
    made = subprocess.run(["make"], cwd=tmp_path / "c99", capture_output=True, text=True, check=False)
    assert made.returncode == 0 and "warning" not in made.stderr, made.stderr
    flown = subprocess.run(["./test_golden"], cwd=tmp_path / "c99", capture_output=True, text=True, check=True)
    assert "the same bits" in flown.stdout
