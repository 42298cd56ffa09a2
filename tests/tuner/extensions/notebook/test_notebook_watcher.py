"""A notebook shows the progress of calls that name no watcher, figures and results in shown units."""

import sys
from types import SimpleNamespace

import pytest

import tuner as gainproof
from tests.tuner.conftest import QUICKSTART, SMALL
from tuner.extensions.notebook import watcher as module
from tuner.extensions.notebook.watcher import MAX_LINES, NotebookWatcher, notebook_watcher
from tuner.search.watcher import Watcher, default_watcher
from tuner.study.build import load_study


class Output:
    """A display that keeps all that it showed."""

    def __init__(self):
        self.shown, self.outputs = [], 0

    def show(self, content):
        self.outputs += 1
        self.shown.append(content)
        return self.shown.append

    @property
    def last(self):
        return self.shown[-1]["text/plain"]


@pytest.fixture
def output():
    return Output()


@pytest.fixture
def kernel(monkeypatch, output):
    """A process that a kernel of Jupyter runs: its IPython shows below the cell."""

    def display(content, *, raw, display_id):
        assert raw and display_id
        output.show(content)
        return SimpleNamespace(update=lambda other, raw: output.shown.append(other))

    fabricated = SimpleNamespace(
        get_ipython=lambda: SimpleNamespace(kernel=object()), display=SimpleNamespace(display=display)
    )
    monkeypatch.setitem(sys.modules, "IPython", fabricated)
    return output


def test_outside_of_a_kernel_calls_are_silent(monkeypatch):
    assert notebook_watcher() is None and type(default_watcher()) is Watcher
    # IPython at a terminal has no kernel.
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: object()))
    assert notebook_watcher() is None
    # A program that imports IPython is none.
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: None))
    assert notebook_watcher() is None


def test_a_run_without_a_watcher_shows_its_progress_in_one_output(kernel, tmp_path, no_pictures):
    gainproof.run(load_study(QUICKSTART, {**SMALL}), tmp_path / "run")
    assert kernel.outputs == 1
    texts = [content["text/plain"] for content in kernel.shown]
    assert any("Stage 1 of" in text and "flights/s" in text for text in texts)
    assert any("Generation 3 of 3" in text for text in texts)
    assert kernel.last.splitlines()[-1].endswith(f"results: {tmp_path / 'run'}")


def test_a_stage_has_a_bar_with_its_share(output):
    watcher = NotebookWatcher(output.show)
    watcher.on_stage("Flying", 200)
    watcher.on_flights_done(50)
    watcher._drawn = 0.0
    watcher.on_flights_done(0)
    assert '<progress value="50' in output.shown[-1]["text/html"] and 'max="200"' in output.shown[-1]["text/html"]
    watcher.on_flights_done(1000)
    assert "<progress" not in output.shown[-1]["text/html"]


def test_a_thousand_reports_change_the_output_a_few_times(output, monkeypatch):
    clock = SimpleNamespace(now=100.0)
    monkeypatch.setattr(module, "perf_counter", lambda: clock.now)
    watcher = NotebookWatcher(output.show)
    watcher.on_stage("Flying", 10_000)
    before = len(output.shown)
    for _ in range(1000):
        clock.now += 0.001
        watcher.on_flights_done(1)
    assert len(output.shown) - before in (3, 4)


def test_text_of_a_stranger_is_no_markup_and_old_lines_go(output):
    watcher = NotebookWatcher(output.show)
    watcher.on_message("<script>alert(1)</script>")
    assert "<script>" not in output.shown[-1]["text/html"]
    for i in range(2 * MAX_LINES):
        watcher.on_warning(f"w{i}")
    assert len(output.last.splitlines()) == MAX_LINES and output.last.endswith(f"w{2 * MAX_LINES - 1}")


def test_results_open_with_the_answer_in_shown_units_and_the_front(small_run):
    html = gainproof.open_results(small_run[1])._repr_html_()
    assert "data:image/png;base64," in html and "<table" in html
    assert "rad</" not in html


def test_a_figure_without_pyplot_shows_itself(small_run):
    assert gainproof.open_results(small_run[1]).figure("front")._repr_png_().startswith(b"\x89PNG")
