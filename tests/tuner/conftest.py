"""One small run of the quickstart, without its margins, shared by the tests of what a run leaves behind."""

from contextlib import nullcontext
from pathlib import Path
from subprocess import CompletedProcess

import pytest

from tests.tuner import in_process
from tests.undrawn import DrawnHere, undrawn

QUICKSTART = Path(__file__).parents[2] / "studies" / "quickstart.toml"
SMALL = {
    "search.population": 8,
    "search.generations": 3,
    "scenario.0.search": 4,
    "scenario.0.held_out": 32,
    "scenario.0.duration": 3.0,
    "margin": [],
}


class NoDrawing:
    """What stands for figures where a test looks at none: they take most of the time of a short run."""

    def begin(self):
        pass

    def stop(self):
        pass

    def wait(self):
        pass


def run_small(folder, threads=2, reuse=(), drawn=False, **changes):
    """Run the quickstart with few candidates and flights; its figures are blank unless they are to be drawn."""
    from tuner.experiments.tuning.run import TuningRun
    from tuner.search.watcher import Watcher
    from tuner.store.folder import Folder
    from tuner.study import load_study

    study = load_study(QUICKSTART, {**SMALL, **{key.replace("__", "."): value for key, value in changes.items()}})
    with nullcontext() if drawn else undrawn():
        return TuningRun(study, Folder.create(folder), Watcher(), threads=threads, reuse=reuse).carry_out()


@pytest.fixture(scope="session", autouse=True)
def drawn_here():
    """Have figures drawn in this process: one that is started to draw them takes three seconds to import what it needs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tuner.report.start_figures", DrawnHere)
        yield


@pytest.fixture(scope="session")
def small_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "small"
    return run_small(folder, drawn=True), folder


@pytest.fixture
def tuner(monkeypatch, capsys):
    """A function that runs a command in this process and returns what `subprocess.run` would, in a tenth of the time."""

    def run(*arguments):
        code, out, errors = in_process.tuner(monkeypatch, capsys, *arguments)
        return CompletedProcess(arguments, int(code), out, errors)

    return run
