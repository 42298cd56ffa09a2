"""`tuner show`: the figures of the folder, at any width, for runs that are finished and runs that are not."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant.errors import StoreError
from tests.tuner.experiments.again.killing import unsealed
from tests.tuner.extensions.contests.report.fabricate_contest import Made
from tests.tuner.extensions.contests.report.fabricate_contest import fabricate as fabricate_contest
from tests.tuner.in_process import tuner
from tests.tuner.report.fabricate import OBJECTIVES, fabricate
from tuner.api.results import TuningResults
from tuner.api.run_report import UnfinishedRun, report_run, unfinished_report
from tuner.cli.printers.run_report import print_run_report
from tuner.cli.terminal import Console
from tuner.documents.verdicts import shown_verdict
from tuner.report.charts.text import TextLayer, legend, place_bar, scatter

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module", params=[1, 2, 3, 5])
def made_up(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("show") / "made-up"
    return fabricate(folder, request.param, ("gusts", "calm air")[: min(request.param, 2)]), request.param


def shown(folder, width, capsys):
    print_run_report(report_run(folder), Console(width=width))
    return capsys.readouterr().out


def flat(text):
    return " ".join(text.split())


def test_every_row_every_gain_and_the_next_step_are_told(made_up, capsys):
    folder, _ = made_up
    summary = json.loads((folder / "summary.json").read_text())
    text = shown(folder, 100, capsys)
    for row in summary["table"]:
        assert row["label"] in text and shown_verdict(row["verdict"]) in text
    for row in summary["variables"]:
        line = next(line for line in text.splitlines() if line.startswith(row["name"]))
        assert f"{row['tuned']:.4g}" in line and f"{row['default']:.4g}" in line and row["unit"].split("^")[0] in line
    for warning in summary["warnings"]:
        assert flat(warning) in flat(text)
    assert f"tuner fly {folder / 'gains.json'}" in text
    assert flat(summary["pick"]["why"]) in flat(text)


@pytest.mark.parametrize("width", [40, 60, 80, 200])
def test_no_line_is_wider_than_the_terminal(made_up, width, capsys):
    """But for commands, which a person copies whole."""
    lines = shown(made_up[0], width, capsys).splitlines()
    assert [line for line in lines if len(line) > width and not line.startswith("tuner ")] == []


def test_two_objectives_are_plotted_and_others_listed(made_up, capsys):
    folder, objectives = made_up
    text = shown(folder, 100, capsys)
    assert ("@ recommended" in text) == (objectives == 2)
    told = report_run(folder)
    assert isinstance(told.results, TuningResults)
    document: Any = told.document
    tuned = next(row for row in document["front"] if row["role"] == "tuned")
    assert tuned["point"] == told.results.tuned
    if objectives != 2:
        assert f"{told.results.tuned} tuned" in text


def test_the_story_is_in_the_units_of_the_folder(made_up):
    """The report turns angles into degrees; the story takes them back."""
    folder, objectives = made_up
    told = report_run(folder)
    results = told.results
    assert isinstance(results, TuningResults)
    document: Any = told.document
    default = next(row for row in document["front"] if row["role"] == "default")
    for i, entry in enumerate(results.objectives):
        held_out = results.held_out_front.held_out[results.held_out_front.of("default")[0], i]
        factor = (
            180.0 / np.pi if OBJECTIVES[i][2] == "rad" else (180.0 / np.pi) ** 2 if "rad^2" in OBJECTIVES[i][2] else 1.0
        )
        assert default["values"][entry.label]["value"] == pytest.approx(held_out / factor, rel=1e-12)
    assert len(document["front"][0]["values"]) == objectives


def test_json_is_the_story_and_nothing_else(made_up, monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "show", made_up[0], "--json")
    told = json.loads(out)
    assert code == 0 and told["finished"] and told["kind"] == "tuning"
    assert told["table"] == json.loads((made_up[0] / "summary.json").read_text())["table"]
    for row in told["gains"]:
        ends = np.log([row["low"], row["high"]]) if row["scale"] == "log" else np.array([row["low"], row["high"]])
        value = np.log(row["tuned"]) if row["scale"] == "log" else row["tuned"]
        assert row["place"] == pytest.approx((value - ends[0]) / (ends[1] - ends[0]), abs=1e-12)


def test_hostile_text_stays_text(tmp_path, capsys):
    folder = fabricate(tmp_path / "made-up", 2, ("[red]gusts[/]",), title="[bold]x[/] [/] \\[")
    text = shown(folder, 100, capsys)
    assert "[bold]x[/] [/] \\[" in text


def test_a_real_run_is_shown(small_run, monkeypatch, capsys):
    code, out, err = tuner(monkeypatch, capsys, "show", small_run[1])
    assert code == 0, err
    assert "\x1b[" not in out
    assert "in the search" in out and "resamples" in flat(out)
    assert f"tuner margins {small_run[1] / 'gains.json'}" in out


def test_an_unfinished_run_says_how_far_it_is(small_run, tmp_path, capsys):
    folder = tmp_path / "stopped"
    shutil.copytree(small_run[1], folder)
    (folder / "summary.json").unlink()
    unsealed(folder)
    lines = (folder / "history.csv").read_text().splitlines()
    (folder / "history.csv").write_text("\n".join(lines[:3]) + "\n")
    told = unfinished_report(folder)
    assert isinstance(told, UnfinishedRun)
    assert (told.generations_done, told.generations, told.finished) == (2, 3, False)
    text = shown(folder, 60, capsys)
    assert "2 of 3 generations" in text and f"tuner resume {folder}" in text
    (folder / "history.csv").unlink()
    assert "0 of 3 generations" in shown(folder, 60, capsys)


@pytest.mark.parametrize("width", [60, 120])
def test_a_contest_shows_its_tables(tmp_path, width, monkeypatch, capsys):
    folder = fabricate_contest(tmp_path / "made-up", Made())
    text = shown(folder, width, capsys)
    assert [line for line in text.splitlines() if len(line) > width and not line.startswith("Results: ")] == []
    found = json.loads((folder / "contest.json").read_text())
    for sentence in found["words"]:
        assert flat(sentence) in flat(text)
    code, out, _ = tuner(monkeypatch, capsys, "show", folder, "--json")
    assert code == 0 and json.loads(out) == found


@pytest.mark.parametrize("make", [lambda folder: None, lambda folder: folder.mkdir()])
def test_what_is_no_results_folder_is_refused(make, tmp_path):
    make(tmp_path / "nothing")
    with pytest.raises(StoreError, match="nothing"):
        report_run(tmp_path / "nothing")


def plot(*layers, width=42, height=11):
    return scatter(layers, ("x [m]", "y [s]"), width, height)


def cells(lines):
    """The inside of a plot, top row first."""
    return [line.split("|", 1)[1] for line in lines if re.match(r"^ *[-\d.e+]* \|", line)]


def test_corners_lie_in_the_corners_and_the_middle_in_the_middle():
    corners = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 4.0], [10.0, 4.0], [5.0, 2.0]])
    inside = cells(plot(TextLayer("o", "points", corners)))
    assert len(inside) == 11
    rows = [i for i, line in enumerate(inside) if "o" in line]
    assert rows == [0, 5, 10]
    columns = [[i for i, mark in enumerate(inside[row]) if mark == "o"] for row in rows]
    (left, right), middle, bottom = columns
    assert bottom == [left, right] and left <= 2
    assert middle == [(left + right + 1) // 2] or middle == [(left + right) // 2]


def test_later_layers_lie_on_top_and_cut_ones_do_not_widen():
    one = np.array([[1.0, 1.0]])
    two = np.array([[1.0, 1.0], [2.0, 2.0]])
    lines = plot(
        TextLayer(".", "tried", np.array([[100.0, 100.0], [1.5, 1.5]]), cut=True),
        TextLayer("o", "f", two),
        TextLayer("@", "r", one),
    )
    inside = "".join(cells(lines))
    assert inside.count("@") == 1 and inside.count("o") == 1 and inside.count(".") == 1
    assert plot(TextLayer("o", "f", two))[-3] == lines[-3]


@pytest.mark.parametrize("value", [0.0, 3.5, -2.0])
def test_a_single_point_has_axes(value):
    assert "".join(cells(plot(TextLayer("@", "one", np.array([[value, value]]))))).count("@") == 1


def test_the_ends_of_the_axes_hold_all_points():
    points = np.random.default_rng(1).normal(size=(40, 2)) * [3.0, 500.0]
    lines = plot(TextLayer("o", "p", points), width=60)
    low, high = (float(text) for text in lines[-3].split())
    assert low <= points[:, 0].min() + 0.02 and high >= points[:, 0].max() - 0.02
    assert max(map(len, lines)) <= 60


def test_the_legend_breaks_between_entries():
    layers = [TextLayer(mark, "name " * 3 + mark, np.zeros((1, 2))) for mark in "abcd"]
    lines = legend(layers, 40)
    assert max(map(len, lines)) <= 40
    assert [entry for line in lines for entry in line.split("   ")] == [
        f"{layer.mark} {layer.name}" for layer in layers
    ]


def test_a_bar_has_its_ends_and_its_middle():
    assert place_bar(0.0, 1.0, 5) == "|@---D|"
    assert place_bar(0.5, 0.5, 5) == "|--@--|"
    assert place_bar(-3.0, 7.0, 5) == "|@---D|"
