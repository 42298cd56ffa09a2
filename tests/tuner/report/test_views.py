"""Tables for readers: what they hold is what the documents hold, in shown units."""

from dataclasses import replace
from math import degrees

import pytest

import tuner
from plant.errors import UnknownNameError
from tests.tuner.extensions.contests.report.fabricate_contest import fabricate as fabricate_contest
from tests.tuner.report.fabricate import fabricate
from tuner.documents.tuning import TuningFolder
from tuner.documents.verdicts import shown_verdict
from tuner.extensions.contests.documents import ContestFolder
from tuner.report.views import (
    contender_margins_view,
    front_view,
    gains_view,
    limits_view,
    margins_view,
    objectives_view,
    tuning_views,
)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("views") / "run"
    fabricate(folder, objectives=3)
    return TuningFolder(folder)


def test_every_table_is_as_wide_as_its_head(results):
    for make in tuning_views(results).values():
        table = make()
        assert {len(row) for row in table.rows} <= {len(table.head)} and len(set(table.head)) == len(table.head)
        assert table.latex.count(" & ") == (len(table.rows) + 1) * (len(table.head) - 1)


def test_objectives_are_the_documents(results):
    table, rows = objectives_view(results), [row for row in results.document.table if row.kind == "objective"]
    assert len(table.rows) == len(rows) == 3
    # The third is an angle: radians in the file, degrees for readers.
    assert table.rows[2][0].endswith("[°]") and rows[2].unit == "rad"
    assert float(table.rows[2][1].split()[0]) == pytest.approx(degrees(rows[2].default.value), rel=0.01)
    assert float(table.rows[0][1].split()[0]) == pytest.approx(rows[0].default.value, rel=0.01)


def test_limits_and_gains_have_a_row_each(results):
    limits = [row for row in results.document.table if row.limit is not None]
    assert [row[-1] for row in limits_view(results).rows] == [shown_verdict(row.verdict) for row in limits]
    assert [row[0].split(" [")[0] for row in gains_view(results).rows] == [row.name for row in results.variables]


def test_the_front_names_default_and_tuned(results):
    names = [row[0] for row in front_view(results).rows]
    assert "default" in names and f"{results.tuned} (tuned)" in names
    assert len(names) == len(results.held_out_front.shown_rows)


def test_margins_of_default_and_tuned_by_loop(results):
    loops = {loop.channel for loop in results.loops}
    assert [row[:2] for row in margins_view(results).rows] == [
        (role, channel) for role in ("default", "tuned") for channel in dict.fromkeys(x.channel for x in results.loops)
    ]
    assert len(loops) == len(margins_view(results).rows) / 2


def test_an_unknown_table_names_those_that_are_there(results):
    with pytest.raises(UnknownNameError, match="objectives"):
        tuner.open_results(results.home).view("frnt")


def test_margins_of_slow_loops_have_digits_and_a_unit_that_suits_them(results, monkeypatch):
    slow = [replace(loop, values=loop.values | {"delay_margin": 1500.0, "bandwidth": 2.5e-4}) for loop in results.loops]
    monkeypatch.setattr(results, "loops", slow)
    table = margins_view(results)
    assert {row[table.head.index("delay margin [min]")] for row in table.rows} == {"25"}
    assert {row[table.head.index("bandwidth [rad/s]")] for row in table.rows} == {"0.00025"}


def test_contests_have_the_margins_of_their_tuned_contenders(tmp_path):
    contest = ContestFolder(fabricate_contest(tmp_path / "contest"))
    for i, entry in enumerate(contest.contenders):
        object.__setattr__(entry, "folder", f"contenders/{entry.slug}" if i < 2 else None)
    for entry in contest.contenders[:2]:
        fabricate(contest.home / str(entry.folder))
    table = contender_margins_view(contest)
    names = [entry.name for entry in contest.contenders[:2]]
    assert list(dict.fromkeys(row[0] for row in table.rows)) == names
    assert {row[1] for row in table.rows} == {"x", "y", "z", "roll", "pitch", "yaw"}
