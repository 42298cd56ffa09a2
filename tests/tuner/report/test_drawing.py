"""Figures drawn beside the run: the same files, and a word where they cannot be drawn."""

import pytest

from plant.errors import StoreError
from tests.tuner.report.fabricate import fabricate
from tuner.report import start_figures, write_figures


def test_the_same_files_as_in_this_process(tmp_path):
    folder = fabricate(tmp_path / "made-up", objectives=2)
    here = {file.name: file.read_bytes() for file in write_figures(folder)}
    for file in (folder / "figures").iterdir():
        file.unlink()
    start_figures(folder).wait()
    assert {file.name: file.read_bytes() for file in (folder / "figures").iterdir()} == here


def test_what_stands_in_the_way_is_told_in_one_line(tmp_path):
    with pytest.raises(StoreError, match="there is no such results folder") as told:
        start_figures(tmp_path / "none").wait()
    assert "\n" not in str(told.value) and not str(told.value).startswith("Error")
