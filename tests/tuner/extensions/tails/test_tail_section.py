"""Limits on rare losses in the page of a run and on its sheets: curves, counts, bounds, and the commands that fly the loss."""

import json
from typing import TypeVar

import numpy as np
import pytest

from objectives.risk import clopper_pearson, upper_bound
from tests.tuner.extensions.tails.test_tail_figure import event
from tests.tuner.report.fabricate import fabricate
from tests.tuner.report.reading import read
from tuner.documents.parts import ShareCount
from tuner.documents.tail import LimitedTail
from tuner.documents.tuning import TuningFolder
from tuner.extensions.tails.panels import FLOOR, limited_panels
from tuner.report import write_report
from tuner.report.charts.chart import Band, Line, Points, Rule
from tuner.report.sheets import search_sheets

Kind = TypeVar("Kind", Band, Line, Points, Rule)

LIMIT, CRUDE = 1e-4, 4096
LOSS = {"metric": None, "unit": "1", "limit": 1.0}
TUNED = event("failure", [(0.25, 0.1), (0.6, 1e-3), (1.0, 2e-5)], low=1.2e-5, high=3e-5, flights=63602, **LOSS)


def counted(events, flights):
    return ShareCount(events=events, flights=flights, upper=upper_bound(events, flights))


def tail(tuned=TUNED, lost=3):
    levels = [(0.1, 1.0), (0.5, 0.01), (1.0, 0.0)]
    default = event("failure", levels, count=counted(0, CRUDE), method="crude Monte Carlo", status="wide", **LOSS)
    unseen = default.curve[-1].model_copy(update={"high": 9e-4})
    return LimitedTail(
        scenario="gusts", confidence=0.95, smallest=3e-5, width=1.0, tuned=tuned,
        default=default.model_copy(update={"curve": [*default.curve[:-1], unseen]}),
        tuned_count=counted(0, 256), default_count=counted(lost, 256),
    )  # fmt: skip


def results_with(folder, tails, code=""):
    """Return a made-up folder whose limit on failures is one on their probability."""
    fabricate(folder)
    summary = json.loads((folder / "summary.json").read_text())
    row = next(row for row in summary["table"] if row.get("metric") == "failure")
    row |= {"limit": LIMIT, "tail_flights": 63602, "tails": [each.content() for each in tails]}
    (folder / "summary.json").write_text(json.dumps(summary))
    resolved = json.loads((folder / "resolved.json").read_text()) | {"scenario": [{"name": "calm"}, {"name": "gusts"}]}
    (folder / "resolved.json").write_text(json.dumps(resolved))
    run = {
        "format": "gainproof-run", "version": 4, "kind": "tuning", "study": "inputs/quickstart.toml", "digest": "", "model": "",
        "generations": 12,
    }  # fmt: skip
    (folder / "run.json").write_text(json.dumps(run))
    (folder / "inputs").mkdir()
    (folder / "inputs" / "quickstart.toml").write_text(code)
    return TuningFolder(folder)


def marks_of(results: TuningFolder, kind: type[Kind]) -> list[Kind]:
    [panel] = limited_panels(results)
    return [mark for mark in panel.marks if isinstance(mark, kind)]


def test_a_panel_holds_both_curves_the_limit_and_where_no_loss_was_seen_the_bound(tmp_path):
    results = results_with(tmp_path / "made", [tail()])
    default, tuned = marks_of(results, Line)
    assert (default.name, tuned.name) == ("default", "tuned")
    assert list(tuned.y) == [0.1, 1e-3, 2e-5]
    # A probability of 0 has no place on a logarithmic axis, its upper end has.
    assert list(default.y) == [1.0, 0.01]
    band = marks_of(results, Band)[0]
    assert band.high[-1] == 9e-4 and band.low[-1] == FLOOR
    assert {(rule.axis, rule.value) for rule in marks_of(results, Rule)} == {("x", 1.0), ("y", LIMIT)}


def test_confirmation_flights_are_points_with_the_interval_of_their_share(tmp_path):
    default, tuned = marks_of(results_with(tmp_path / "made", [tail()]), Points)
    low, high = clopper_pearson(3, 256)
    assert (default.x[0], default.y[0]) == (1.0, pytest.approx(3 / 256))
    assert default.y_ends is not None
    assert np.ravel(default.y_ends) == pytest.approx([float(low), float(high)])
    assert tuned.look.symbol == "triangle-down" and tuned.y_ends is None
    assert tuned.y[0] == pytest.approx(1.0 - 0.05 ** (1.0 / 256))


def test_the_page_has_line_curve_and_the_commands_of_the_lost_flight(tmp_path):
    results = results_with(tmp_path / "made", [tail()], '[law]\nfile = "mine.py"\n')
    write_report(results.home)
    page = read(results.home)
    assert "tail-0" in page.ids and "tail-0" in page.data["charts"]
    assert "2.0e-5 [1.2e-5, 3.0e-5] (63 602 flights, splitting)" in page.text
    assert "gusts, default, failure: 0 of 4096: at most 0.073 %" in page.text
    flown = "--study made/inputs/quickstart.toml --scenario 1 --code made/inputs/mine.py"
    assert f"tuner tail made/gains.json {flown} --event failure --to 3e-05 --width 1 --out tail-1" in page.text
    assert f"tuner fly made/gains.json {flown} --flight tail-1/point-1 --plot tail-1/point-1.png" in page.text


def test_no_command_seeks_a_flight_where_none_was_lost(tmp_path):
    below = event("failure", [(0.25, 0.1), (1.0, 0.0)], status="below", high=1e-5, **LOSS)
    results = results_with(tmp_path / "made", [tail(below)])
    write_report(results.home)
    text = read(results.home).text
    assert "rarer than 3.0e-05, at most 1.0e-05" in text and "tuner tail" not in text


def test_the_figure_of_tails_is_one_of_the_run_where_it_has_such_a_limit(tmp_path):
    results = results_with(tmp_path / "made", [tail(), tail()])
    assert len(search_sheets(results)["tail"].panels) == 2
    assert "tail" not in search_sheets(results_with(tmp_path / "without", []))
