"""What a comparison says is what flying the same gains alone says, on scenarios of its own stream."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from objectives.decisions import DecisionSpace
from objectives.problem import Constraint, FlightBatch, Problem
from plant.quadrotor.airframes import load
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT, SEARCH
from tests.tuner.experiments.again.killing import assert_covered
from tests.tuner.experiments.compare.conftest import SEEDS, compared
from tests.tuner.in_process import tuner
from tuner.documents.opening import open_results
from tuner.experiments.compare.entrants import Entrant
from tuner.experiments.compare.flying import comparison_problem, fly_all
from tuner.experiments.compare.fronts import front_of
from tuner.experiments.compare.plan import COMPARE, MAX_POINTS, thinned


def alone(study, row, count=SEEDS, stream=COMPARE):
    """A gains row flown by the study's own problem, which knows nothing of comparisons."""
    problem = Problem(
        study.system, DecisionSpace((), (), tuple(row)), study.objectives, study.constraints, study.seed, 2
    )
    batches = tuple(FlightBatch(entry.spec, stream, count) for entry in study.scenarios)
    return problem.evaluate_gains(np.array([row]), batches)


def values(document, name):
    return {row.quantity: row.value for row in document.estimates if row.contender == name}


def test_the_stream_is_none_of_the_others():
    assert COMPARE not in (SEARCH, HELD_OUT, CONFIRMATION, "check")


def test_values_are_those_of_the_gains_flown_alone(small_run, comparison):
    outcome, _ = small_run
    asked, _, document = comparison
    for entry in (asked.entries[0], asked.entries[2]):
        evaluation = alone(outcome.study, entry.row)
        found = values(document, entry.contender.name)
        for objective, value in zip(outcome.study.objectives, evaluation.values[0], strict=True):
            assert found[objective.label] == value


def test_the_same_gains_twice_do_not_differ_at_all(comparison):
    rows = [row for row in comparison[2].differences if {row.first, row.second} == {"small", "same"}]
    assert rows
    assert all(row.difference == row.low == row.high == 0.0 and row.lower is None for row in rows)


def test_another_airframe_flies_in_the_same_air_with_its_own_numbers(comparison):
    """As if the scenarios had been drawn for it alone: same air and noise, and the same relative spread of its own vehicle."""
    asked, result, document = comparison
    entry = asked.entries[3]
    study = entry.contender.study
    assert study.airframe.name == "f450"
    assert study.system.vehicle == load("f450").vehicle != asked.entries[0].problem.system.vehicle
    evaluation = alone(study, entry.row)
    found = values(document, entry.contender.name)
    for objective, value in zip(study.objectives, evaluation.values[0], strict=True):
        assert found[objective.label] == value
    assert not np.array_equal(result.flown.scores[2], result.flown.scores[3])


def test_differences_are_of_flights_and_not_of_values(small_run, comparison):
    """The paired interval of a mean is that of the mean of the flightwise differences: its normal width within 40 %."""
    _, result, document = comparison
    label = next(o.label for o in small_run[0].study.objectives if o.risk.name == "mean")
    i = [quantity.label for quantity in result.study.quantities].index(label)
    apart = result.flown.scores[2, i] - result.flown.scores[0, i]
    row = next(r for r in document.differences if (r.first, r.second, r.quantity) == ("small", "softer", label))
    assert row.difference == pytest.approx(apart.mean(axis=0), rel=1e-12)
    half = 1.96 * apart.std(axis=0, ddof=1) / SEEDS**0.5
    assert 0.6 * half < 0.5 * (row.high - row.low) < 1.4 * half


def test_another_order_turns_the_differences_round(paths):
    _, _, one = compared([paths[0], paths[2]])
    _, _, other = compared([paths[2], paths[0]], threads=1)
    for row, turned in zip(one.differences, other.differences, strict=True):
        assert (row.first, row.second) == (turned.second, turned.first)
        assert row.difference == -turned.difference
        assert row.low == pytest.approx(-turned.high, abs=1e-12)


def test_threads_do_not_matter(paths, comparison):
    _, result, _ = compared(paths, threads=1)
    assert np.array_equal(result.flown.scores, comparison[1].flown.scores)


def test_fronts_are_flown_again_on_the_same_scenarios(small_run, comparison):
    outcome, _ = small_run
    asked, result, _ = comparison
    front = result.fronts[0]
    assert front.points and set(front.points) <= set(asked.entrants[0].points)
    for k, row in enumerate(front.gains):
        evaluation = alone(outcome.study, row)
        assert np.array_equal(front.values[k], evaluation.values[0])
        assert np.all(evaluation.violations[0, : len(outcome.study.constraints)] <= 0.0)
    for row in front.values:
        assert not any(np.all(other <= row) and np.any(other < row) for other in front.values)
    assert np.all(front.low <= front.values) and np.all(front.values <= front.high)
    assert [len(own.points) for own in result.fronts[1:]] <= [1, 1, 1]


def test_what_breaks_a_limit_is_not_on_a_front(comparison):
    """A limit on an objective itself, at the middle of the front: the half above it goes, and nothing else does."""
    asked, result, _ = comparison
    whole = result.fronts[0]
    assert len(whole.points) > 1
    objectives = asked.study.base.objectives
    most = float(np.sort(whole.values[:, 0])[len(whole.points) // 2 - 1])
    contenders = [
        replace(entry, study=replace(entry.study, constraints=(Constraint(objectives[0], most),)))
        for entry in asked.study.contenders
    ]
    tight = replace(asked.study, contenders=tuple(contenders))
    problem = comparison_problem(tight, contenders[0])
    entries = [replace(entry, problem=problem) for entry in asked.contenders[0].offered if entry.point in whole.points]
    flown = fly_all(tight, entries, 2, lambda flights: None)
    front = front_of(tight, entries, flown)
    assert set(front.points) == {p for p, row in zip(whole.points, whole.values, strict=True) if row[0] <= most}
    assert 0 < len(front.points) < len(whole.points)


def test_what_is_dominated_on_these_flights_is_not_on_a_front(comparison):
    """Weaker copies of every point of the front beside it; who dominates whom is found by looking at every pair."""
    asked = comparison[0]
    weaker = [
        replace(entry, point=f"{entry.point}/{n}", row=entry.row * 0.8**n)
        for entry in asked.contenders[0].offered
        for n in (0, 1, 2, 4)
    ]
    flown = fly_all(asked.study, weaker, 2, lambda flights: None)
    front = front_of(asked.study, weaker, flown)
    objectives = asked.study.base.objectives
    values = np.stack([o.risk.apply(flown.samples(i, o.scenario)) for i, o in enumerate(objectives)], axis=1)
    kept = [
        k
        for k in range(len(weaker))
        if not flown.failed[k].any()
        and all(
            q.limit is None or q.objective.risk.apply(flown.samples(i, q.objective.scenario))[k] <= q.limit
            for i, q in enumerate(asked.study.quantities)
        )
    ]
    best = [k for k in kept if not any(np.all(values[j] <= values[k]) and np.any(values[j] < values[k]) for j in kept)]
    assert {weaker[k].point for k in best} == set(front.points)
    assert len(best) < len(kept)


def test_rows_of_a_folder_are_those_of_its_gains_file(comparison):
    """Front.csv and gains.json tell the same numbers."""
    asked = comparison[0]
    assert np.array_equal(asked.entries[0].row, asked.entries[1].row)


def test_a_point_under_a_limit_is_picked_by_the_held_out_values_of_its_run(small_run, comparison):
    """Where every front has them: a run with one that flew other scenarios has no such table."""
    outcome, _ = small_run
    asked, result, _ = comparison
    front = result.fronts[0]
    for point, picked in zip(front.points, front.picked, strict=True):
        row = outcome.names.index(point)
        np.testing.assert_allclose(picked, outcome.finalists.evaluation.values[row], rtol=1e-15)
    assert result.best_under
    entries = [replace(entry, picked=None) for entry in asked.contenders[0].offered]
    assert len(entries) > 1
    flown = fly_all(asked.study, entries, 2, lambda flights: None)
    assert front_of(asked.study, entries, flown).picked is None


def test_few_flights_and_other_airframes_are_told(comparison):
    warnings = comparison[2].warnings
    assert any("f450" in text for text in warnings)
    assert any("would put 8 into its tail" in text for text in warnings)


def test_a_long_front_is_thinned_evenly_and_keeps_its_recommended_point(comparison):
    small = comparison[0].entrants[0]
    count = 5 * MAX_POINTS
    points = tuple(f"p{i}" for i in range(count))
    long = replace(
        small,
        points=points,
        rows=np.tile(small.rows[:1], (count, 1)) * np.arange(count)[:, None],
        point="p17",
        picked=np.arange(2.0 * count).reshape(count, 2),
    )
    kept = thinned(long, np.arange(count)[::-1])
    assert isinstance(kept, Entrant) and {"p0", "p17", f"p{count - 1}"} <= set(kept.points)
    assert MAX_POINTS <= len(kept.points) <= MAX_POINTS + 1
    numbers = [int(point[1:]) for point in kept.points]
    assert max(np.diff(numbers)) <= 6
    assert np.array_equal(kept.rows[-1], long.rows[count - 1])
    assert kept.picked[:, 0].tolist() == [2.0 * number for number in numbers]
    assert thinned(small, np.arange(len(small.points))) is small


def test_the_folder_holds_numbers_figures_and_a_page(comparison, written):
    assert_covered(written)
    document = json.loads((written / "comparison.json").read_text())
    assert document == json.loads(comparison[2].text())
    for name in ("front", "values", "differences", "08_position"):
        assert (written / "figures" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert (written / "figures" / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    page = (written / "report.html").read_text()
    assert "gainproof comparison" in page
    assert not re.search(r'<(?:script|link|img)[^>]*(?:src|href)="?https?:', page)
    contest = open_results(written)
    assert [entry.name for entry in contest.contenders] == ["small", "same", "softer", "larger"]
    assert contest.fronts is not None and contest.fans and contest.traces


def test_the_command_prints_every_contender_and_verdict(paths, monkeypatch, capsys):
    code, out, err = tuner(
        monkeypatch, capsys, "compare", paths[0], paths[1], paths[2], "--seeds", SEEDS, "--threads", 2
    )
    assert code == 0, err
    lines = out.splitlines()
    blocks = [
        sum(line.startswith(f"{name} ") and "[" in line for line in lines) for name in ("small", "same", "softer")
    ]
    assert blocks[0] == blocks[1] == blocks[2] > 2
    assert any(line.startswith("same ") and line.rstrip().endswith("same") for line in lines)
    assert re.search(r"(better|worse)$", "\n".join(line.rstrip() for line in lines), re.MULTILINE)


def test_json_is_the_document_and_nothing_else(paths, monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "compare", paths[0], paths[2], "--seeds", SEEDS, "--json")
    document = json.loads(out)
    assert code == 0
    assert document["kind"] == "comparison" and document["stream"] == COMPARE and document["first"] == "small"
    assert [row["kind"] for row in document["contenders"]] == ["results", "gains"]


def test_show_tells_a_comparison(written, monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "show", written)
    assert code == 0
    assert "larger" in out and "report.html" in out
