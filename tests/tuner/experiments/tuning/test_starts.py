"""Searches that start from an earlier run: its points are flown, the rest is as it was, and a run is the same without it."""

import json
import shutil

import numpy as np
import pytest

from plant.seeds import generator
from tests.tuner.conftest import QUICKSTART, SMALL, run_small
from tests.tuner.experiments.again.killing import CHANGES, compare, finish, killed, result_of, run_arguments
from tuner.experiments.tuning import starts
from tuner.experiments.tuning.starts import earlier_points, nearest_passing, surrounding_points
from tuner.search.initial_design import first_passing, initial_design, latin_hypercube
from tuner.study.build import load_study
from tuner.study.starts import merged_points

POINTS = [{"attitude.lambda": value} for value in (2.0, 3.0, 4.0, 5.5, 6.0, 7.0)]


@pytest.fixture
def earlier(small_run, tmp_path):
    return shutil.copytree(small_run[1], tmp_path / "earlier", ignore=shutil.ignore_patterns("flights", "figures"))


def test_half_of_the_first_generation_is_of_the_run_a_third_around_and_the_rest_a_hypercube(
    earlier, tmp_path, no_figures
):
    sizes = {"search__population": 12, "search__generations": 1}
    outcome = run_small(tmp_path / "run", search__starts=[str(earlier), {"points": POINTS}], **sizes)
    study, first = outcome.study, outcome.generations[0].points
    wanted = merged_points(study.search.starts, study.space)[:6]
    assert len(wanted) == 6 == study.search.most_starts
    assert np.array_equal(first[0], study.space.point(study.default_row)) and np.array_equal(first[1:7], wanted)
    around = surrounding_points(wanted, 4, generator(study.seed, "search/around", 0), None)
    drawn = latin_hypercube(1, first.shape[1], generator(study.seed, "search/initial", 0))
    assert np.array_equal(first[7:11], around) and np.array_equal(first[11:], drawn)
    assert f"The search starts from {earlier} " in json.loads((tmp_path / "run" / "summary.json").read_text())["search"]


def test_several_runs_take_turns(earlier):
    two = [str(earlier), {"points": POINTS[:2]}]
    study = load_study(QUICKSTART, {**SMALL, "search.starts": two})
    rows = merged_points(study.search.starts, study.space)
    front, given = (entry.units(study.space) for entry in study.search.starts)
    assert np.array_equal(rows[:4], [front[0], given[0], front[1], given[1]]) and np.array_equal(rows[4:], front[2:])


def test_the_default_and_repetitions_are_not_flown_twice():
    repeated = [{"attitude.lambda": 5.0}, POINTS[0], POINTS[0], POINTS[1]]
    study = load_study(QUICKSTART, {**SMALL, "search.starts": [{"points": repeated}]})
    default = study.space.point(study.default_row)[None]
    taken, spare, texts = earlier_points(study, default, 4)
    assert (
        texts == []
        and spare.shape == (0, taken.shape[1])
        and np.array_equal(taken, merged_points(study.search.starts, study.space)[[1, 3]])
    )


def test_points_around_lie_between_points_and_near_them():
    ends = np.array([[0.3, 0.5], [0.7, 0.5]])
    drawn = surrounding_points(ends, 400, np.random.default_rng(1), None)
    assert drawn.shape == (400, 2) and np.all((drawn >= 0.0) & (drawn <= 1.0))
    # Across the line steps alone, 0.1 wide; along it a point of either, or what a blend of both over 1.5 of 0.4 adds.
    assert np.std(drawn[:, 1]) == pytest.approx(0.1, rel=0.15) and np.mean(drawn, axis=0) == pytest.approx(
        0.5, abs=0.02
    )
    assert 0.2 < np.std(drawn[:, 0]) < 0.3


def test_points_around_keep_the_limits_and_none_comes_from_nothing():
    ends = np.array([[0.45, 0.5], [0.5, 0.45]])
    drawn = surrounding_points(ends, 20, np.random.default_rng(1), inside)
    assert len(drawn) == 20 and inside(drawn).all()
    assert surrounding_points(ends[:0], 20, np.random.default_rng(1), inside).shape == (0, 2)
    assert len(surrounding_points(ends, 20, np.random.default_rng(1), lambda points: points[:, 0] < -1.0)) == 0


def test_further_points_stand_in_for_what_fails_of_the_hypercube():
    starts, spare = np.full((1, 2), 0.01), np.array([[0.9, 0.9], [0.02, 0.03], [0.03, 0.02], [0.025, 0.025]])
    screened = list[int]()

    def corner(points):
        screened.append(len(points))
        return points.sum(axis=1, keepdims=True) - 0.1

    first = initial_design(starts, 8, np.random.default_rng(1), corner, spare)
    assert len(first) == 8 and {tuple(row) for row in spare[1:].tolist()} <= {tuple(row) for row in first.tolist()}
    assert [0.9, 0.9] not in first.tolist()
    # Six hypercubes of seven points, as feasible points are at hand; without them up to 48.
    assert sum(screened) == 7 + 6 * 7 + len(spare)
    assert np.array_equal(initial_design(starts, 8, np.random.default_rng(1), None, spare)[:1], starts)


def test_no_more_points_are_screened_than_needed():
    points, screened = np.linspace(0.0, 1.0, 200)[:, None], list[int]()

    def low(batch):
        screened.append(len(batch))
        return batch[:, 0] < 0.5

    assert np.array_equal(first_passing(points, 30, low), points[:30]) and sum(screened) < 60
    assert np.array_equal(first_passing(points, 150, low), points[:100])
    # Where few are expected to pass, as many as may hold enough of them are screened at once; the points are the same.
    for share, count in ((1.0, 30), (0.5, 60), (0.1, 200), (0.0, 200)):
        screened.clear()
        assert np.array_equal(first_passing(points, 30, low, share), points[:30]) and screened == [count]


def inside(points):
    return points.sum(axis=1) <= 1.0


def test_a_point_beyond_a_limit_moves_to_the_nearest_that_keeps_it():
    points = np.array([[0.2, 0.3], [0.51, 0.51], [0.9, 0.9]])
    moved = nearest_passing(points, inside(points), np.random.default_rng(1), inside)
    assert np.array_equal(moved[0], points[0]) and len(moved) == 2 and inside(moved).all()
    # The limit is 0.014 away, and the third of the widths of steps is seven times that.
    assert np.linalg.norm(moved[1] - points[1]) < 0.05


def test_points_at_ends_of_their_ranges_move_within_them():
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    anywhere = np.ones(len(corners) * starts.DRAWS, dtype=bool)
    moved = nearest_passing(corners, np.zeros(8, dtype=bool), np.random.default_rng(2), lambda drawn: anywhere)
    assert (
        moved.shape == corners.shape and np.all((moved >= 0.0) & (moved <= 1.0)) and np.abs(moved - corners).max() < 0.1
    )


def test_points_that_cannot_be_moved_are_replaced_by_others_and_said(monkeypatch):
    study = load_study(QUICKSTART, {**SMALL, "search.starts": [{"points": POINTS}]})
    default, given = study.space.point(study.default_row)[None], merged_points(study.search.starts, study.space)
    column = [each.name for each in study.space.variables].index("attitude.lambda")

    def screening(highest):
        return lambda points: points[:, column] >= given[highest, column] - 1e-12

    monkeypatch.setattr(starts, "WIDTHS", ())
    taken, spare, texts = earlier_points(study, default, 3, screening(2))
    assert np.array_equal(taken, given[2:5]) and np.array_equal(spare, given[5:]) and texts == []
    taken, _, texts = earlier_points(study, default, 3, screening(4))
    assert np.array_equal(taken, given[4:])
    assert texts == ["Starting points left out for limits known without flying, which nothing near keeps: 1 of 3."]


def test_points_at_limits_are_flown_near_by(tmp_path, no_figures):
    """Points of the quickstart's front for 20 deg of phase margin, where 35 deg are asked for."""
    least = [{"quantity": "phase_margin", "min": 35}]
    beyond = {"attitude.omega_o": 20.0, "attitude.k1": 0.0, "attitude.lambda": 9.0, "attitude.k2": 12.0}
    given = [{**beyond, "position.omega_c": value} for value in (1.0, 1.5, 2.0, 2.5)]
    outcome = run_small(tmp_path / "run", search__starts=[{"points": given}], search__generations=1, margin=least)
    study, first = outcome.study, outcome.generations[0]
    wanted = merged_points(study.search.starts, study.space)[: study.search.most_starts]
    assert np.all(outcome.problem.excess(wanted)[:, -1] > 0.0)
    # The default, four points of the run and two around them; the rest is a hypercube, of which a part keeps the limit.
    assert first.evaluation.flown[:7].all()
    far = np.abs(first.points[1:5] - wanted).max(axis=1)
    assert np.all((far > 0.0) & (far < 0.3))


@pytest.mark.slow
def test_killed_and_resumed_without_the_earlier_run(earlier, tmp_path):
    changes = {**CHANGES, "scenario.0.duration": 3.0, "search.starts": [str(earlier)]}
    finish(*run_arguments(tmp_path / "alone", changes), "--threads", 1)
    folder = tmp_path / "killed"
    assert killed(folder, lambda _: (folder / "generations" / "0001.npz").exists(), changes)
    shutil.rmtree(earlier)
    finish("resume", folder, "--threads", 2)
    compare(result_of(folder), result_of(tmp_path / "alone"))
    moved = folder.rename(tmp_path / "moved")
    (moved / "start.json").unlink()
    finish("resume", moved)
    compare(result_of(moved), result_of(tmp_path / "alone"))
    said, _ = finish("verify", tmp_path / "alone")
    assert "every bit is the same" in said


def test_the_option_names_runs_and_the_preview_tells_them(earlier, tmp_path, monkeypatch, tuner):
    monkeypatch.chdir(tmp_path)
    sets = [part for key, value in SMALL.items() for part in ("--set", f"{key}={json.dumps(value)}")]
    points = len((earlier / "front.csv").read_text().splitlines()) - 2
    text = f"The search starts from earlier ({points} points)."
    named = ("--set", 'search.starts=["earlier"]')
    assert text in " ".join(tuner("check", QUICKSTART, *sets, *named).stdout.split())
    assert text in " ".join(tuner("plan", QUICKSTART, *sets, *named).stdout.split())
    run = tuner("run", QUICKSTART, *sets, "--set", "search.generations=1", "--starts", "earlier", "--out", "run")
    assert run.returncode == 0 and text in json.loads((tmp_path / "run" / "summary.json").read_text())["search"]
    lost = tuner("run", QUICKSTART, "--starts", "nowhere", "--out", "other")
    assert lost.returncode == 2 and "there is no results folder or gains.json nowhere" in " ".join(lost.stderr.split())
    assert not (tmp_path / "other").exists()
