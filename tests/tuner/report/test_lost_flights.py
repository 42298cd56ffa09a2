"""Finalists that failed flights when held out are marked, counted and never out of sight, in every drawing of the trade-off."""

import json
from typing import Any

import numpy as np
import pytest
from matplotlib.container import ErrorbarContainer

from tests.tuner.extensions.contests.report.fabricate_contest import Made
from tests.tuner.extensions.contests.report.fabricate_contest import fabricate as fabricate_contest
from tests.tuner.in_process import tuner
from tests.tuner.report.fabricate import FINALISTS, fabricate
from tests.tuner.report.reading import Page
from tuner.documents.opening import open_results
from tuner.documents.tuning import TuningFolder
from tuner.extensions.contests.page import contest_page
from tuner.report import write_report
from tuner.report.charts.text import front_lines
from tuner.report.comparison.figures import fronts_figure
from tuner.report.figures import front_figure

LOST = 3
LEGEND = "six failed flights (three points)"


@pytest.fixture(scope="module", params=[1, 2, 3])
def folder(request, tmp_path_factory):
    return fabricate(tmp_path_factory.mktemp("lost") / "made-up", objectives=request.param, lost=LOST, responses=False)


def drawn(ax, label):
    """The places (n, 2) of the marks with a label that begins so, of all marks of that look."""
    (found,) = [line for line in ax.get_lines() if str(line.get_label()).startswith(label)]
    return np.stack(found.get_data(), axis=1)


def count_of(line: Any) -> int:
    """How many marks a line of a figure is made of."""
    return len(line.get_xdata())


def test_the_paper_figure_crosses_them_out_at_the_edge_and_counts_them(folder):
    results = TuningFolder(folder)
    for ax in [ax for ax in front_figure(results).axes if ax.get_visible()]:
        crosses = drawn(ax, LEGEND)
        assert len(crosses) == LOST
        ends = np.array([ax.get_xlim(), ax.get_ylim()]).T
        assert np.all((crosses >= ends[0]) & (crosses <= ends[1]))
        # Forty times the others' values: at the right edge, and at the top where that is an objective too.
        assert np.all(crosses[:, 0] == ends[1, 0])
    legend = [text.get_text() for text in front_figure(results).legends[0].get_texts()]
    assert LEGEND in legend


def test_legends_of_the_paper_figure_lie_within_it(folder):
    figure = front_figure(TuningFolder(folder))
    figure.draw_without_rendering()
    (legend,) = figure.legends
    box, whole = legend.get_window_extent(), figure.bbox
    assert whole.x0 <= box.x0 and box.x1 <= whole.x1 and box.y1 <= whole.y1
    assert any(text.get_text().startswith("beyond the axes (") for text in legend.get_texts())


def test_every_finalist_is_drawn_once(folder):
    results = TuningFolder(folder)
    for ax in [ax for ax in front_figure(results).axes if ax.get_visible()]:
        inside = sum(count_of(bars.lines[0]) for bars in ax.containers if isinstance(bars, ErrorbarContainer))
        edge = [line for line in ax.get_lines() if str(line.get_marker()) in ("<", ">", "^", "v")]
        beyond = sum(map(count_of, edge))
        assert beyond >= LOST and inside + beyond == len(results.held_out_front.points) == FINALISTS + 1


def test_a_run_without_lost_flights_has_no_such_marks(tmp_path):
    results = TuningFolder(fabricate(tmp_path / "made-up", responses=False))
    labels = [str(line.get_label()) for line in front_figure(results).axes[0].get_lines()]
    assert [label for label in labels if "failed" in label] == []
    assert "failed flights" not in "\n".join(front_lines(results, 72, 16))


def test_the_page_knows_and_says_how_many_each_lost(folder):
    page = Page(write_report(folder).read_text())
    points = page.data["points"]
    assert [point["lost"] for point in points] == [0] * (len(points) - LOST) + [2] * LOST
    assert "2 of 256 held-out simulations failed" in points[-1]["texts"]["faults"]
    assert "failed flights when held out (three points, six flights)" in page.text


def test_an_older_folder_that_does_not_tell_is_read(tmp_path):
    assert TuningFolder(fabricate(tmp_path / "old", old=True)).held_out_front.lost.tolist() == [0] * (FINALISTS + 1)


def test_the_terminal_plot_marks_them_at_its_edge(tmp_path, monkeypatch, capsys):
    folder = fabricate(tmp_path / "made-up", lost=LOST, responses=False)
    lines = front_lines(TuningFolder(folder), 72, 16)
    assert f"x failed flights when held out ({LOST} points, {2 * LOST} flights; at the edge if beyond it)" in " ".join(
        lines
    )
    # Far up and to the right of everything: the last place of the top line.
    assert lines[1].endswith("x")
    code, out, _ = tuner(monkeypatch, capsys, "show", folder)
    assert code == 0 and f"failed flights when held out ({LOST} points" in " ".join(out.split())


@pytest.mark.parametrize("objectives", [1, 2])
def test_fronts_of_a_contest_cross_them_out(tmp_path, objectives):
    made = Made(objectives=objectives, lost=2)
    contest = open_results(fabricate_contest(tmp_path / "contest", made))
    assert contest.fronts is not None
    figure = fronts_figure(contest)
    assert figure is not None
    crosses = [line for line in figure.axes[0].get_lines() if line.get_marker() == "x"]
    assert sum(map(count_of, crosses)) == 2 * len(made.names)
    traces = json.dumps(Page(contest_page(contest).text()).data)
    assert traces.count('"x-thin"') == len(made.names)
    assert "two failed flights" in traces
    clean = open_results(fabricate_contest(tmp_path / "clean", Made(objectives=objectives)))
    assert "x-thin" not in json.dumps(Page(contest_page(clean).text()).data)
