"""Shared by the tests of the tool, which keeps them cheap: one small run, blank figures, the command line without a process.

A run takes a second, its figures as much again, a process two for its imports. So a test that only reads what a run leaves
behind takes `small_run` (or `small_contest`, or a comparison from the `conftest.py` of its folder), and copies
the folder where it spoils something. Commands run in this process by the fixture `tuner`; a process of its own is for tests of
the process itself: its streams, signals, environment or memory. Figures are blank but in `tests/tuner/report/`; `no_figures`
leaves them out. Bundles of C hold few golden vectors by `few_golden_vectors`. Folders whose files share such a fixture belong
into `TOGETHER` of `tests/conftest.py`, so that one worker makes it for all. What takes 10 s all the same, and has a small
stand-in, is marked `slow` and named in `tests/proofs.txt`; `.ci/run` prints the twenty slowest tests and the seconds of each stage.

What made tests dear, most first: a loop of its own (laws, features of the vehicle and metrics together are one kernel, of some
10 s: take those of another test, and make a step once for all vehicles of the same features); a fit of a log (5 s: move numbers of
a fit that is there, as `shifted` of test_random_effects.py does); a process (2 s for its imports: start one that forks);
populations and pilots as large as a study's (12 candidates show what a search keeps).
"""

from contextlib import nullcontext
from functools import partial
from pathlib import Path
from subprocess import CompletedProcess

import pytest

from tests.tuner import in_process
from tests.undrawn import undrawn

QUICKSTART = Path(__file__).parents[2] / "studies" / "quickstart.toml"
SMALL = {
    # A model takes a third of so short a run, and as long again when it is gone on with.
    "search.algorithm": "nsga2",
    "search.population": 8,
    "search.generations": 3,
    # Bits of a small search depend on nothing that comes with the tool.
    "search.starts": [],
    "scenario.0.search": 4,
    "scenario.0.held_out": 32,
    "scenario.0.duration": 3.0,
    "margin": [],
}


class NoDrawing:
    """A stand-in for figures where a test looks at none: they take most of the time of a short run."""

    def begin(self, results):
        pass

    def go_on(self, results):
        pass

    def stop(self):
        pass

    def wait(self):
        pass


def run_small(folder, threads=2, reuse=(), **changes):
    """Run the quickstart with few candidates and flights."""
    from tuner.experiments.tuning.run import TuningRun
    from tuner.search.watcher import Watcher
    from tuner.store.folder import Folder
    from tuner.study.build import load_study

    study = load_study(QUICKSTART, {**SMALL, **{key.replace("__", "."): value for key, value in changes.items()}})
    return TuningRun(study, Folder.create(folder), Watcher(), threads=threads, reuse=reuse).carry_out()


@pytest.fixture(scope="session", autouse=True)
def blank_figures():
    """Have figures written blank and by this process: drawing takes half of a short run, a process that draws three seconds."""
    with undrawn():
        yield


@pytest.fixture(autouse=True)
def _code_is_not_announced(monkeypatch):
    """Leave out the line that code of the user's gets before its first run on a machine, which a test cannot know to be the first."""
    monkeypatch.setattr("tuner.text.errors.code_announced", nullcontext)


@pytest.fixture
def no_figures(monkeypatch):
    """Have runs write no figures at all, which a blank page still takes a third of a second for."""
    monkeypatch.setattr("tuner.report.start_figures", lambda folder: NoDrawing())


@pytest.fixture
def no_pictures(small_run, no_figures, monkeypatch):
    """Have runs write neither figures nor a page, once the small run has them."""
    monkeypatch.setattr("tuner.report.write_report", lambda *_: None)


@pytest.fixture
def few_golden_vectors(monkeypatch):
    """Have bundles of C hold 16 golden vectors of each kind, not 200."""
    from tuner.exchange.c99.golden import golden

    monkeypatch.setattr("tuner.exchange.c99.export.golden", partial(golden, steps=16))


@pytest.fixture(scope="session")
def small_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "small"
    # Blank whoever asks first: tests compare its files with those of other runs.
    with undrawn():
        return run_small(folder), folder


@pytest.fixture
def tuner(monkeypatch, capsys):
    """A function that runs a command in this process and returns what `subprocess.run` would, in a tenth of the time."""

    def run(*arguments):
        code, out, errors = in_process.tuner(monkeypatch, capsys, *arguments)
        return CompletedProcess(arguments, int(code), out, errors)

    return run


@pytest.fixture
def unflown(monkeypatch):
    """Fly nothing before and after rounding: each pair of laws of an autopilot takes 10 s of compilation."""
    monkeypatch.setattr("tuner.exchange.verification.fly_both", lambda *_: ([], (0, 0)))


@pytest.fixture
def uncompiled(monkeypatch):
    """Have mock-up units hold no binary."""
    monkeypatch.setattr("tuner.extensions.fmi.archive.compiler", lambda: None)
