"""The command `tuner bench`: its place in the help, its two outputs, and processor time on one thread."""

import json

import numpy as np
import pytest

from plant.threads import threads_used, use_threads
from tests.tuner.in_process import tuner
from tuner.cli.app import command_groups
from tuner.cli.main import commands
from tuner.extensions.bench import speed

FIGURES = {"lanes_steps_per_s": 12345678.9, "threads": 2, "simd": "avx2"}


@pytest.fixture
def measured(monkeypatch):
    """Arguments of the measurement, which is replaced by fixed figures."""
    given = []
    monkeypatch.setattr(speed, "bench", lambda *arguments: given.append(arguments) or FIGURES)
    return given


def test_it_stands_last_behind_the_commands_of_the_core():
    groups = command_groups(commands("").commands)
    assert groups["Further"][-2:] == ["schema", "bench"]
    assert "bench" not in groups["Of extensions"] and "bench" not in groups["Every day"]


def test_without_it_the_help_has_no_such_line():
    assert "bench" not in command_groups([name for name in commands("").commands if name != "bench"])["Further"]


def test_figures_are_printed_as_lines_of_three_digits(measured, monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "bench", "--flights", "16", "--threads", "2")
    first, *rows = out.splitlines()
    assert code == 0 and measured == [(16, 2)] and first.startswith("Measuring closed-loop plant steps per second")
    assert [row.split() for row in rows] == [["lanes_steps_per_s", "1.23e+07"], ["threads", "2"], ["simd", "avx2"]]


def test_figures_as_json_are_alone_and_whole(measured, monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "bench", "--json")
    assert code == 0 and json.loads(out) == FIGURES and measured == [(1024, None)]


def test_margins_are_timed_on_one_thread_in_batches_and_the_threads_come_back():
    usual, seen = threads_used(), []
    use_threads(3)
    try:
        time = speed._busy(lambda gains: seen.append((len(gains), threads_used())), np.zeros((10, 2)), 4)
        assert threads_used() == 3
    finally:
        use_threads(usual)
    assert time >= 0.0 and seen == [(4, 1), (4, 1), (2, 1)] * speed.ROUNDS


def test_the_threads_come_back_after_an_error_too():
    usual = threads_used()
    use_threads(3)

    def fail(gains):
        raise ZeroDivisionError(gains)

    try:
        with pytest.raises(ZeroDivisionError):
            speed._busy(fail, np.zeros((1, 2)), 1)
        assert threads_used() == 3
    finally:
        use_threads(usual)
