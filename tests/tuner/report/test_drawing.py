"""Figures drawn beside the run: the same files, written by the run, and nothing of them once the run is dead."""

import subprocess
import sys
import time

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


@pytest.mark.parametrize("begun", [False, True])
def test_it_can_be_given_up_at_any_time(tmp_path, begun):
    folder = fabricate(tmp_path / "made-up", objectives=2)
    drawing = start_figures(folder)
    if begun:
        drawing.begin()
    drawing.stop()
    assert not (folder / "figures").exists()


# A run that is killed while its figures are drawn: before they are begun, and after.
PARENT = """
import sys, time
from pathlib import Path
from tuner.report import start_figures
drawing = start_figures(Path(sys.argv[1]))
if sys.argv[2] == "True":
    drawing.begin()
print(drawing._process.pid, flush=True)
time.sleep(60)
"""


def alive(number):
    """Whether a process is there and no zombie: nobody may be left to bury it here."""
    try:
        with open(f"/proc/{number}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] not in "ZX"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
@pytest.mark.parametrize("begun", [False, True])
def test_it_ends_with_its_parent_and_leaves_nothing(tmp_path, begun):
    folder = fabricate(tmp_path / "made-up", objectives=2)
    before = sorted(folder.rglob("*"))
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, str(folder), str(begun)], stdout=subprocess.PIPE, text=True
    )
    assert parent.stdout is not None
    with parent.stdout:
        child = int(parent.stdout.readline())
        assert alive(child)
        parent.kill()
        parent.wait()
    end = time.monotonic() + 30.0
    while alive(child):
        assert time.monotonic() < end
        time.sleep(0.02)
    assert sorted(folder.rglob("*")) == before
