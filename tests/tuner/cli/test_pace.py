"""What a progress display says of speed and time: flights that were made count, flights on record do not."""

import io
import shutil
import time
from types import SimpleNamespace
from typing import Any

import pytest

import tuner.report
from tests.tuner.conftest import NoDrawing
from tuner.cli import display
from tuner.cli.display import Pace, TerminalWatcher
from tuner.cli.terminal import Console
from tuner.experiments.again.resume import reopen
from tuner.experiments.tuning.run import TuningRun
from tuner.search.watcher import BestValue, compilation


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
    assert 1 <= int(last.split()[-3]) <= 60 and last.endswith(" s left")


def test_compiling_shows_the_time_on_a_terminal_and_is_one_line_in_a_pipe():
    shown, piped = io.StringIO(), io.StringIO()
    with TerminalWatcher(Console(file=shown, force_terminal=True, width=120)) as watcher, compilation(watcher):
        time.sleep(1.2)
    assert "0:00:01" in shown.getvalue() and "Compiled in 1." in shown.getvalue()
    with TerminalWatcher(Console(file=piped, width=120)) as watcher, compilation(watcher):
        pass
    assert len(piped.getvalue().splitlines()) == 1


def generation(number, flights, seconds) -> Any:
    """A generation as the display reads it: its flights and the time that they took."""
    evaluation = SimpleNamespace(flights=flights, flight_seconds=seconds)
    return SimpleNamespace(number=number, hypervolume=0.25, feasible_share=0.5, evaluation=evaluation)


PLAN = {"Searching": 200, "Refining": 100, "Held-out check": 700}


def test_the_time_left_holds_the_stages_after_the_search_and_the_report(clock):
    """100 flights take 1 s and the choice of candidates 9 s: a generation more is 10 s, 800 flights more are 8 s."""
    told = io.StringIO()
    watcher = TerminalWatcher(Console(file=told, width=200))
    watcher.on_plan(PLAN)
    watcher.on_stage("Searching", 200)
    lines = []
    for number in range(2):
        clock.now += 10.0
        watcher.on_flights_done(0 if number else 1)
        clock.now += 10.0 if not number else 0.0
        watcher.on_flights_done(100 - (not number))
        watcher.on_generation(generation(number, 100, 1.0), 2)
        lines = told.getvalue().splitlines()
    assert lines[0] == "Stage 1 of 4: Searching, up to 200 flights"
    first, last = (float(line.split()[-3]) for line in lines[1:])
    later = 800 / 100.0 + display.REPORT_SECONDS
    assert first == pytest.approx(20.0 + later) and last == later


def test_the_bar_of_a_run_never_walks_back_and_says_the_stage(clock):
    console = Console(file=io.StringIO(), force_terminal=True, width=120)
    watcher = TerminalWatcher(console)
    watcher.on_plan(PLAN)
    shown = []

    def look():
        (task,) = watcher._progress.tasks
        assert task.total
        shown.append(task.completed / task.total)
        return task.description

    watcher.on_stage("Searching", 200)
    assert look() == "Stage 1 of 4: Searching"
    for flights in (150, 400):
        clock.now += 1.0
        watcher.on_flights_done(flights)
        look()
    column = next(part for part in watcher._progress.columns if isinstance(part, display.PaceColumn))
    assert column.render(watcher._progress.tasks[0]).plain.endswith(" left")
    assert " 0:00:00 left" not in column.render(watcher._progress.tasks[0]).plain
    watcher.on_stage("Held-out check", 500)
    assert look() == "Stage 3 of 4: Held-out check"
    watcher.on_flights_done(500)
    look()
    assert shown == sorted(shown) and shown[-1] <= 1.0
    watcher.on_writing("figures")
    (task,) = watcher._progress.tasks
    assert task.description == "Stage 4 of 4: Writing figures"


def test_a_log_file_names_the_last_stage_once(clock):
    printed = io.StringIO()
    watcher = TerminalWatcher(Console(file=printed, width=200))
    watcher.on_plan(PLAN)
    for part in ("responses", "report", "figures"):
        watcher.on_writing(part)
    assert printed.getvalue().splitlines() == ["Stage 4 of 4: Writing results"]


def test_the_best_feasible_value_stands_beside_the_defaults(clock):
    told = io.StringIO()
    watcher = TerminalWatcher(Console(file=told, width=200))
    watcher.on_stage("Searching", 100)
    best = [BestValue("mean(travel)", "1/s", 3.25, 4.5, True), BestValue("rms", "m", None, 0.5, False)]
    clock.now += 1.0
    watcher.on_flights_done(10)
    watcher.on_best_values(best)
    watcher.on_generation(generation(0, 10, 1.0), 4)
    assert "mean(travel) 3.25 1/s (default 4.5)  rms none feasible (default 0.5, breaks limits)" in told.getvalue()
