"""Figures drawn beside the run: the same files, written by the run, and nothing of them once the run is dead."""

import os
import subprocess
import sys
import time
from typing import Any, cast

import pytest

from plant.errors import InputError, StoreError
from tests.tuner.report.fabricate import fabricate
from tuner.report import opened, start_figures, write_figures
from tuner.report.charts import printer
from tuner.report.charts.printer import early
from tuner.report.drawing import FigureProcess


def draw(folder):
    drawing, results = start_figures(folder), opened(folder)
    drawing.begin(results)
    drawing.go_on(results)
    drawing.wait()


@pytest.mark.slow
def test_the_same_files_as_in_this_process(tmp_path):
    folder = fabricate(tmp_path / "made-up", objectives=2)
    here = {file.name: file.read_bytes() for file in write_figures(folder)}
    for file in (folder / "figures").iterdir():
        file.unlink()
    draw(folder)
    assert {file.name: file.read_bytes() for file in (folder / "figures").iterdir()} == here


@pytest.mark.slow
def test_responses_may_come_later(tmp_path):
    folder = fabricate(tmp_path / "made-up", objectives=2)
    (folder / "responses.npz").rename(tmp_path / "later")
    drawing, results = start_figures(folder), opened(folder)
    drawing.begin(results)
    (tmp_path / "later").rename(folder / "responses.npz")
    drawing.go_on(results)
    drawing.wait()
    assert {file.stem for file in (folder / "figures").iterdir()} == {"front", "progress", "responses"}


def test_what_stands_in_the_way_is_told_in_one_line(tmp_path):
    drawing = start_figures(tmp_path)
    drawing._give({"front": cast(Any, "not a sheet")})
    with pytest.raises(StoreError, match="AttributeError: 'str' object") as told:
        drawing.wait()
    assert "\n" not in str(told.value)


def test_files_of_a_process_that_failed_are_not_taken(tmp_path, monkeypatch):
    """It handed over one file, whole, and then ended with an error: others may be missing."""
    program = (
        """import sys; sys.stdout.write('{"figures/a.svg": 1}\\na'); sys.stdout.flush(); sys.exit('out of memory')"""
    )
    pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    monkeypatch.setattr(
        "tuner.report.drawing.taken", lambda: subprocess.Popen([sys.executable, "-I", "-c", program], **pipes)
    )
    with pytest.raises(StoreError, match="out of memory"):
        FigureProcess(tmp_path).wait()
    assert not list(tmp_path.iterdir())


def test_a_process_that_died_is_told_of_when_it_is_waited_for(tmp_path):
    folder = fabricate(tmp_path / "made-up", objectives=2)
    drawing, results = start_figures(folder), opened(folder)
    drawing._process.kill()
    drawing._process.wait()
    drawing.begin(results)
    drawing.go_on(results)
    with pytest.raises(StoreError, match="no figures drawn"):
        drawing.wait()


@pytest.mark.parametrize("begun", [False, True])
def test_it_can_be_given_up_at_any_time(tmp_path, begun):
    folder = fabricate(tmp_path / "made-up", objectives=2)
    drawing = start_figures(folder)
    if begun:
        drawing.begin(opened(folder))
    drawing.stop()
    assert not (folder / "figures").exists()


def test_it_imports_nothing_that_only_reads():
    """All of them take time, and the process has a core that the run could have."""
    readers = {"pyarrow", "pandas", "pydantic", "objectives.problem", "plant.quadrotor.cascade", "unittest.mock"}
    code = f"import sys; import tuner.report.charts.printing, tuner.report.charts.paper; print({readers} & {{*sys.modules}})"
    assert subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout == "set()\n"


# A run that is killed while its figures are drawn: before they are begun, and after.
PARENT = """
import sys, time
from pathlib import Path
from tuner.report import opened, start_figures
drawing = start_figures(Path(sys.argv[1]))
if sys.argv[2] == "True":
    drawing.begin(opened(Path(sys.argv[1])))
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
@pytest.mark.parametrize("begun", [pytest.param(False, marks=pytest.mark.slow), True])
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


def test_a_process_that_was_started_early_draws_and_one_that_nobody_took_ends(tmp_path):
    folder = fabricate(tmp_path / "made-up", objectives=2)
    with early():
        ready = printer._EARLY[0]
        drawing = start_figures(folder)
        assert drawing._process is ready
        drawing.stop()
        other = printer.taken()
        assert other is not ready
        printer.end(other)
    with pytest.raises(InputError), early():
        ready = printer._EARLY[0]
        raise InputError("given nothing")
    assert ready.poll() is not None
    assert not printer._EARLY


def test_a_matplotlibrc_of_the_working_folder_changes_no_figure_and_starts_no_program(tmp_path):
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\nfont.size: 30\nbackend: module://canary\n")
    (tmp_path / "canary.py").write_text("open('ran', 'w')")
    (tmp_path / "latex").write_text("#!/bin/sh\ntouch ran\n")
    (tmp_path / "latex").chmod(0o755)
    code = (
        "import matplotlib; from tuner.report.charts.paper import STYLE, style\n"
        "assert matplotlib.rcParams['text.usetex'] and matplotlib.rcParams['font.size'] == 30\n"
        "with style():\n"
        "    assert not matplotlib.rcParams['text.usetex'] and matplotlib.rcParams['font.size'] == STYLE['font.size']\n"
        "    from matplotlib.figure import Figure\n"
        "    figure = Figure(); figure.add_subplot().set_title('x'); figure.savefig('x.png')\n"
    )
    environment = os.environ | {"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, check=True)
    assert (tmp_path / "x.png").is_file() and not (tmp_path / "ran").exists()
