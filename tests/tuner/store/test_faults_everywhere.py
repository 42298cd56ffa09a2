"""A full disk or Ctrl-C at any write, fsync and rename of a run, report and figures included: one line, and a resume to the same bytes.

Here a few instants of each; all of them: pytest -n 0 -m slow tests/tuner/store/test_faults_everywhere.py.
"""

import json
import shutil
import sys

import pytest

import tuner.report
from plant.output_files import ASIDE
from tests.tuner.conftest import QUICKSTART
from tests.tuner.experiments.again.killing import assert_sealed, compare, result_of
from tests.tuner.in_process import tuner as command
from tests.tuner.store.faults import AFTER, BEFORE, FULL, KINDS, Faults
from tuner.report.drawing import FigureProcess

# Everything that a run writes, in the fewest flights.
TINY = {
    "search.algorithm": "nsga2",
    "search.population": 8,
    "search.generations": 2,
    "scenario.0.search": 4,
    "scenario.0.held_out": 8,
    "scenario.0.duration": 2.0,
    "margin": [],
    "constraint": [{"metric": "failure", "max": 0.5}],
}


def toml(value):
    return json.dumps(value).replace('": ', '" = ')


def run(folder):
    return [
        "run",
        QUICKSTART,
        "--out",
        folder,
        "--json",
        *(part for key, value in TINY.items() for part in ("--set", f"{key}={toml(value)}")),
    ]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """An undisturbed run, and how many writes, fsyncs and renames it takes."""
    folder = tmp_path_factory.mktemp("whole") / "r"
    patch = pytest.MonkeyPatch()
    patch.setattr(sys, "argv", ["tuner", *map(str, run(folder))])
    from tuner.cli.main import _invoke
    from tuner.text.errors import guarded

    with Faults(folder) as faults:
        assert guarded(_invoke) == 0
    patch.undo()
    return folder, faults.count


def assert_survived(whole, nth, kind, folder, monkeypatch, capsys):
    expected, _ = whole
    with Faults(folder, nth, kind) as faults:
        code, _, err = command(monkeypatch, capsys, *run(folder))
    assert err.count("\n") == 1 and "Traceback" not in err, (faults.told, err)
    if kind == FULL:
        assert code == 2 and err.startswith("Error: ") and "No space left on device" in err, (faults.told, err)
    else:
        assert code == 130 and err.startswith("Interrupted; "), (faults.told, err)
    assert not list(folder.rglob(f"*{ASIDE}")), faults.told
    kept, undisturbed = result_of(folder), result_of(expected)
    assert [name for name in kept if kept[name] != undisturbed[name]] == [], faults.told
    if (folder / "run.json").exists():
        assert f"`tuner resume {folder}`" in err, (faults.told, err)
        arguments = ["resume", folder, "--json"]
    else:
        assert f"remove {folder} and give the command again" in err, (faults.told, err)
        shutil.rmtree(folder)
        arguments = run(folder)
    code, _, err = command(monkeypatch, capsys, *arguments)
    assert (code, err) == (0, ""), faults.told
    compare(result_of(folder), undisturbed)
    assert_sealed(folder, expected)


# Shares of all the calls: among inputs, flights, generations, front, responses, report, figures, manifest.
@pytest.mark.parametrize(
    ("share", "kind"),
    [
        (0.3, FULL),
        *(
            pytest.param(*each, marks=pytest.mark.slow)
            for each in ((0.04, BEFORE), (0.62, AFTER), (0.9, FULL), (1.0, BEFORE))
        ),
    ],
)
def test_a_fault_at_some_calls(share, kind, whole, tmp_path, monkeypatch, capsys):
    assert_survived(whole, round(share * whole[1]), kind, tmp_path / "r", monkeypatch, capsys)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_fault_at_every_call(kind, whole, tmp_path, monkeypatch, capsys):
    for nth in range(1, whole[1] + 1):
        assert_survived(whole, nth, kind, tmp_path / f"r{nth}", monkeypatch, capsys)
        shutil.rmtree(tmp_path / f"r{nth}")


def test_every_call_is_counted(whole):
    """Of each file one write, two fsyncs (its bytes, its name) and one rename."""
    folder, count = whole
    files = [file for file in folder.rglob("*") if file.is_file() and file.name != ".lock"]
    # manifest.json is written twice, history.csv with each of two generations.
    assert count == 4 * (len(files) + 2)


@pytest.mark.slow
def test_a_fault_while_the_report_is_drawn_by_its_own_process(whole, tmp_path, monkeypatch, capsys):
    """As the command does it: the figures come from a process, which is ended with the run."""
    monkeypatch.setattr(tuner.report, "start_figures", FigureProcess)
    assert_survived(whole, whole[1] - 3, BEFORE, tmp_path / "r", monkeypatch, capsys)
