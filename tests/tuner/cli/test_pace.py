"""What a progress display says of speed and time: flights that were made count, flights on record do not."""

import io
import shutil
import time

import pytest

import tuner.report
from tests.tuner.conftest import NoDrawing
from tuner.cli import display
from tuner.cli.display import Pace, TerminalWatcher
from tuner.cli.terminal import Console
from tuner.experiments.again.resume import reopen
from tuner.experiments.tuning.run import TuningRun
from tuner.search.watcher import compilation


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(display, "perf_counter", clock)
    return clock


def test_the_rate_is_of_flights_made_over_the_time_after_the_record(clock):
    pace = Pace()
    clock.now += 60.0
    pace.skip()
    assert pace.rate is None
    clock.now += 2.0
    pace.add(30)
    pace.skip()
    assert pace.rate == pytest.approx(15.0)
    assert pace.seconds == pytest.approx(2.0)


def test_time_left_is_that_of_what_is_still_to_be_flown(clock):
    console = Console(file=io.StringIO(), force_terminal=True, width=120)
    watcher = TerminalWatcher(console)
    watcher.on_stage("Searching", 1000)
    clock.now += 50.0
    watcher.on_flights_skipped(600)
    clock.now += 1.0
    watcher.on_flights_done(100)
    column = next(part for part in watcher._progress.columns if isinstance(part, display.PaceColumn))
    assert column.render(watcher._progress.tasks[0]).plain == "100 flights/s  0:00:03 left"


def lines_of(path, monkeypatch):
    monkeypatch.setattr(tuner.report, "write_report", lambda *_: None)
    monkeypatch.setattr(tuner.report, "start_figures", lambda folder: NoDrawing())
    told = io.StringIO()
    study, folder = reopen(path, None)
    with TerminalWatcher(Console(file=told, width=200)) as watcher:
        TuningRun(study, folder, watcher, threads=2).carry_out()
    return [line for line in told.getvalue().splitlines() if line.startswith("generation ")]


def test_a_replay_says_on_record_instead_of_a_speed(small_run, tmp_path, monkeypatch):
    shutil.copytree(small_run[1], tmp_path / "copy")
    lines = lines_of(tmp_path / "copy", monkeypatch)
    assert len(lines) == 3 and all(line.endswith("  on record") for line in lines)
    next((tmp_path / "copy" / "flights").glob("search-0002-*")).unlink()
    *replayed, last = lines_of(tmp_path / "copy", monkeypatch)
    assert len(replayed) == 2 and all(line.endswith("  on record") for line in replayed)
    assert last.endswith(" flights/s  0 s left")


def test_compiling_shows_the_time_on_a_terminal_and_is_one_line_in_a_pipe():
    shown, piped = io.StringIO(), io.StringIO()
    with TerminalWatcher(Console(file=shown, force_terminal=True, width=120)) as watcher, compilation(watcher):
        time.sleep(1.2)
    assert "0:00:01" in shown.getvalue() and "Compiled in 1." in shown.getvalue()
    with TerminalWatcher(Console(file=piped, width=120)) as watcher, compilation(watcher):
        pass
    assert len(piped.getvalue().splitlines()) == 1
