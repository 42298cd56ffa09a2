"""A run whose requirements are known without flying: what it spares, writes down, offers and says."""

import json
import re
import shutil
from dataclasses import replace
from io import StringIO

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from objectives.requirements import Requirement, Screen
from plant.quadrotor.gains import gain_addresses
from tests.tables import read_frame
from tests.tuner.conftest import QUICKSTART, SMALL
from tuner.cli.printers.tuning import comparison_table
from tuner.documents.summary import Summary
from tuner.documents.tuning import TuningFolder
from tuner.experiments.tuning.run import TuningRun
from tuner.report import write_report
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.study.build import load_study

GENERATIONS, POPULATION, SEARCH, HELD_OUT = 3, 8, 4, 32


class Listener(Watcher):
    """Adds up what a progress bar would show."""

    def __init__(self):
        self.expected, self.ended = [], []

    def on_stage(self, stage, flights):
        self.expected.append(flights)
        self.ended.append(0)

    def on_flights_done(self, flights):
        self.ended[-1] += flights


def gain_of(study, address):
    return next(gain.column for gain in gain_addresses(study.system.cascade) if gain.address == address)


def required(study, limit=12.0, hard=True, address="roll.lambda"):
    """A stand-in for theory: roll.lambda itself must be at least so large, and x.zeta not above 3 (always kept)."""
    columns = [gain_of(study, address), gain_of(study, "x.zeta")]
    asked = (
        Requirement("slope(roll)", "slope of the sliding surface", "rad/s", limit, "min", hard),
        Requirement("damping(x)", "damping ratio", "1", 3.0, "max", hard),
    )
    return replace(study, screens=(Screen(asked, lambda gains: gains[:, columns]),))


def run(folder, study, watcher=None):
    return TuningRun(study, Folder.create(folder), watcher or Watcher(), threads=2).carry_out()


@pytest.fixture(scope="module")
def small():
    return load_study(QUICKSTART, SMALL)


@pytest.fixture(scope="module")
def ran(small, tmp_path_factory):
    folder, watcher = tmp_path_factory.mktemp("runs") / "required", Listener()
    with pytest.MonkeyPatch.context() as patch:
        # The first generation stays a plain hypercube, so that some of it breaks the requirement.
        patch.setattr("tuner.search.initial_design.MAX_EXTRA_HYPERCUBES", 0)
        return run(folder, required(small), watcher), folder, watcher


def tried(folder):
    return pd.concat([read_frame(file) for file in sorted((folder / "generations").glob("*.npz"))])


def test_only_what_keeps_the_requirements_is_flown_but_for_the_default(ran):
    _, folder, _ = ran
    rows = tried(folder)
    slope = rows["requirement:slope(roll)"].to_numpy()
    np.testing.assert_allclose(slope, rows["gain:attitude.lambda"], rtol=1e-12)
    assert rows.flown.tolist() == [row == 0 or value >= 12.0 for row, value in enumerate(slope)]
    assert 0 < sum(rows.flown) < len(rows)
    np.testing.assert_allclose(rows["violation:slope(roll)"], np.maximum(1.0 - slope / 12.0, 0.0), atol=1e-12)
    assert set(rows["violation:damping(x)"]) == {0.0}
    assert max(rows["requirement:damping(x)"]) <= 3.0
    assert set(rows.feasible[slope < 12.0]) == {False}
    assert set(rows.failures[~rows.flown]) == {1.0}


def test_flights_are_counted_when_flown_and_the_bar_reaches_its_end(ran):
    outcome, folder, watcher = ran
    rows, history = tried(folder), pd.read_csv(folder / "history.csv")
    summary = json.loads((folder / "summary.json").read_text())
    unflown = [int((~rows.flown[: POPULATION * (k + 1)]).sum()) for k in range(GENERATIONS)]
    assert history.screened.tolist() == unflown
    assert history.flights_saved.tolist() == [SEARCH * count for count in unflown]
    assert (history.flights + history.flights_saved + history.flights_raced).tolist() == [
        SEARCH * POPULATION * (k + 1) for k in range(GENERATIONS)
    ]
    assert summary["screened"] == {"candidates": unflown[-1], "flights": SEARCH * unflown[-1]}
    assert (
        summary["flights"]
        == outcome.flights
        == int(rows.flown.sum()) * SEARCH - history.flights_raced.iloc[-1] + (len(outcome.finalist_rows) + 2) * HELD_OUT
    )
    assert watcher.ended == watcher.expected


def test_the_front_offered_keeps_them_and_the_default_is_judged_by_real_flights(ran):
    outcome, folder, _ = ran
    front = pd.read_csv(folder / "front.csv")
    slopes = front["requirement:slope(roll)"].tolist()
    assert min(slopes[1:]) >= 12.0
    assert slopes[0] == outcome.study.default_row[gain_of(outcome.study, "roll.lambda")] < 12.0
    # Of points that keep what is known without flying, some break a limit on flights that the search did not see.
    assert not front.feasible[0] and front.feasible[1:].any()
    assert outcome.finalists.evaluation.flown.all()
    assert outcome.archive.flown[0] and outcome.generations[0].evaluation.failures[0] < 1.0


def test_the_summary_tells_requirements_without_intervals(ran):
    outcome, folder, _ = ran
    rows = [row for row in json.loads((folder / "summary.json").read_text())["table"] if row["kind"] == "requirement"]
    assert [row["label"] for row in rows] == ["slope(roll)", "damping(x)"]
    slope = rows[0]
    assert (slope["unit"], slope["limit"], slope["sense"], slope["hard"]) == ("rad/s", 12.0, "min", True)
    assert slope["quantity"] == "slope of the sliding surface" and slope["verdict"] == "kept"
    column = gain_of(outcome.study, "roll.lambda")
    for name, row in (("default", 0), ("tuned", outcome.tuned)):
        assert slope[name] == {"value": outcome.gains(row)[column], "low": None, "high": None}
    assert slope["difference"]["value"] == slope["tuned"]["value"] - slope["default"]["value"]
    assert json.loads((folder / "gains.json").read_text())["objectives"][-2]["label"] == "slope(roll)"


def test_terminal_and_page_show_them(ran):
    _, folder, _ = ran
    summary = json.loads((folder / "summary.json").read_text())
    console = Console(width=160, record=True, file=StringIO())
    console.print(comparison_table(Summary.model_validate(summary)))
    text = console.export_text()
    assert "min 12 rad/s" in text and "satisfied: " in text
    page = write_report(folder).read_text(encoding="utf-8")
    assert "slope(roll)" in page and "damping(x)" in page
    # Angles in degrees: 12 rad/s are 687.5 deg/s.
    assert "min 687.5" in page and "°/s" in page and "slope of the sliding surface" in page
    assert re.search(r"satisfy all \d+ limits|violate \d+ of \d+ limits", page)
    (slope, _) = TuningFolder(folder).requirements
    assert slope.limit == pytest.approx(np.degrees(12.0)) and slope.tuned.low is None


def test_what_is_broken_or_unbounded_is_said(ran, tmp_path):
    _, folder, _ = ran
    copy = shutil.copytree(folder, tmp_path / "copy")
    summary = json.loads((copy / "summary.json").read_text())
    summary["table"][-1] |= {"verdict": "broken", "tuned": {"value": None, "low": None, "high": None}}
    (copy / "summary.json").write_text(json.dumps(summary))
    page = write_report(copy).read_text(encoding="utf-8")
    assert re.search(r"violate \d+ of \d+ limits: [^.<]*damping\(x\)", page)
    console = Console(width=160, record=True, file=StringIO())
    console.print(comparison_table(Summary.model_validate(summary)))
    assert "violated: " in (text := console.export_text()) and "unbounded" in text


def test_a_requirement_that_nobody_can_keep_is_named(small, tmp_path):
    outcome = run(tmp_path / "none", required(small, limit=1000.0))
    assert outcome.archive.flown.tolist() == [True] + [False] * (GENERATIONS * POPULATION - 1)
    (said,) = [text for text in outcome.warnings if "No candidate" in text]
    best = outcome.archive.requirements[:, 0].max(axis=0)
    assert "so none but the default was flown" in said
    assert f"slope(roll) at least 1000 rad/s was kept by 0 of 24 candidates, closest {best:.4g} rad/s" in said
    assert "damping(x) at most 3 was kept by 24 of 24 candidates" in said
    # The one that breaks least is the steepest, and it is flown in the end.
    assert outcome.archive.requirements[outcome.candidates[0], 0] == best
    assert outcome.finalists.evaluation.failures[1] < 1.0
    broken = outcome.finalists.evaluation.violations[1] > 0.0
    assert broken[-2:].tolist() == [True, False]
    assert outcome.generations[-1].hypervolume == 0.0
    assert [row.verdict for row in outcome.required_rows] == ["broken", "kept"]


def test_a_soft_requirement_that_nobody_keeps_is_flown_and_named(small, tmp_path):
    outcome = run(tmp_path / "soft", required(small, limit=1000.0, hard=False))
    assert outcome.archive.flown.all()
    (said,) = [text for text in outcome.warnings if "No candidate" in text]
    assert "so none could be offered" in said


def test_kept_requirements_change_no_bit_of_a_run(small_run, small, tmp_path):
    # An eye that is always content: NSGA-II hears of one constraint more, all else stays.
    plain, watched = small_run[0], run(tmp_path / "watched", required(small, limit=0.0))
    assert np.array_equal(plain.archive.points, watched.archive.points)
    assert np.array_equal(plain.finalists.evaluation.values, watched.finalists.evaluation.values)
    assert plain.flights == watched.flights
