"""What a run keeps of every finalist: responses, constrained quantities, margins."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from objectives.margins.margins import MarginModel
from objectives.margins.trim import Trim
from plant.errors import InputError
from plant.quadrotor.scenarios import HELD_OUT
from tests.tables import frame_written
from tests.tuner.conftest import QUICKSTART
from tuner.analysis.held_out import compare_known
from tuner.analysis.responses import LEVELS, quantiles
from tuner.documents.parts import on_page
from tuner.documents.states import tightest_margins
from tuner.documents.tuning import SHOWN
from tuner.experiments.tuning import fans
from tuner.experiments.tuning.fans import (
    FAN_SCENARIOS,
    SERIES,
    Fans,
    drawn,
    flight_of,
    response_table,
    scenario_fans,
    worst_flights,
)
from tuner.experiments.tuning.problem import batches, problem_of
from tuner.experiments.tuning.tables import (
    POINTS,
    constraint_table,
    margin_table,
    worst_state_table,
)
from tuner.study.build import load_study


@pytest.fixture(scope="module")
def outcome(small_run):
    return small_run[0]


def written(table) -> Any:
    """A table as pandas reads its file."""
    return frame_written(table)


def test_responses_of_every_finalist_with_the_flight_in_which_it_did_worst(outcome):
    table = written(response_table(outcome))
    assert list(table.point.unique()) == outcome.names
    assert np.all(table.low <= table["median"]) and np.all(table["median"] <= table.high)
    assert set(table.groupby(["point", "signal"], observed=True).size()) == {len(table) // (10 * len(outcome.names))}
    evaluation, row = outcome.finalists.evaluation, outcome.tuned
    scores = evaluation.samples(0, "steps in gusts")[row]
    mine = table[table.point == outcome.names[row]]
    index = mine.worst_flight.iloc[0]
    assert scores[index] == scores.max()
    # Flown alone, and in a fan of all, the flight is the same.
    spec = outcome.study.scenarios[0].spec
    alone = flight_of(outcome, row, drawn(outcome, spec, [int(index)])).actual[0, :, 0]
    assert mine[mine.signal == "x"].worst.to_numpy() == pytest.approx(alone, abs=1e-6)
    assert index < len(scores) <= FAN_SCENARIOS


def test_a_worst_flight_is_the_same_in_the_fan_and_beyond_it(outcome):
    entry = outcome.study.scenarios[0]
    for inside, beyond in zip(*[scenario_fans(outcome, entry.spec, n) for n in (entry.held_out, 1)], strict=True):
        assert inside.worst_flight == beyond.worst_flight
        np.testing.assert_array_equal(inside.worst, beyond.worst)


def test_fans_recorded_while_held_out_flights_are_made_are_those_flown_again(outcome, monkeypatch):
    study, seen = outcome.study, []
    problem = problem_of(study, 1, None)
    recorded = Fans(study, problem)
    recorded.record()
    for batch in batches(study, HELD_OUT):
        problem.results(outcome.finalist_rows, batch, 0, batch.count)
    made = problem.flights_made
    monkeypatch.setattr(fans, "flight_of", lambda *_: seen.append(1))
    table = written(response_table(outcome, recorded))
    assert not seen
    assert made == problem.flights_made == len(outcome.names) * sum(entry.held_out for entry in study.scenarios)
    monkeypatch.undo()
    assert table.equals(written(response_table(outcome)))


def test_a_worst_flight_beyond_the_recorded_ones_is_flown_by_itself(outcome):
    study, entry = outcome.study, outcome.study.scenarios[0]
    problem = problem_of(study, 1, None)
    recorded = Fans(replace(study, scenarios=(replace(entry, held_out=1),)), problem)
    recorded.record()
    problem.results(outcome.finalist_rows, replace(batches(study, HELD_OUT)[0]), 0, 1)
    for mine, flown in zip(
        scenario_fans(outcome, entry.spec, 1, recorded), scenario_fans(outcome, entry.spec, 1), strict=True
    ):
        assert mine.worst_flight == flown.worst_flight
        for name in SERIES:
            np.testing.assert_array_equal(getattr(mine, name), getattr(flown, name))


@pytest.mark.parametrize("count", [1, 2, 21, 64])
def test_quantiles_of_fans_are_those_of_numpy_to_the_last_bit(count):
    values = np.random.default_rng(count).normal(size=(count, 50, 3))
    values[-1, 4, 1] = np.nan
    values[0, 5] = values[-1, 5]
    np.testing.assert_array_equal(quantiles(values, LEVELS), np.quantile(values, LEVELS, axis=0))


def test_worst_flight_goes_by_the_first_objective_that_counts_there(outcome):
    found = worst_flights(outcome, "steps in gusts")
    assert found.tolist() == outcome.finalists.evaluation.scores[:, 0].argmax(axis=-1).tolist()


def test_constraints_of_every_finalist_are_what_made_them_feasible(outcome):
    table: Any = pd.DataFrame(constraint_table(outcome))
    study = outcome.study
    assert list(table.point.unique()) == outcome.names
    # An automatic limit asks for no more than the default does.
    of_default = table[table.point == "default"].set_index("label").value
    limits = {
        entry.objective.label: max(entry.most, 1.02 * of_default[entry.objective.label]) if entry.floor else entry.most
        for entry in study.constraints
    }
    assert list(table.label.unique()) == list(limits)
    assert np.all(table.low <= table.value) and np.all(table.value <= table.high)
    kept = ~(table.value > table.label.map(limits)).groupby(table.point).any()
    surely = ~(table.high > table.label.map(limits)).groupby(table.point).any()
    feasible = dict(zip(outcome.names, outcome.finalists.feasible.tolist(), strict=True))
    assert all(kept[name] for name in outcome.names if feasible[name])
    assert any(feasible.values())
    # What keeps its limits and is not feasible lacks confidence in one of them.
    assert not any(surely[name] for name in outcome.names if kept[name] and not feasible[name])
    default = table[table.point == "default"]
    assert not default[["difference", "difference_low", "difference_high"]].to_numpy().any()


@pytest.fixture(scope="module")
def margins(outcome):
    return written(margin_table(outcome))


def test_margins_of_every_finalist_and_loop_are_read_off_the_curve_beside_them(outcome, margins):
    assert list(margins.point.unique()) == outcome.names
    assert list(margins.channel.unique()) == ["x", "y", "z", "roll", "pitch", "yaw"]
    assert margins.stable.any()
    for row in margins[margins.stable].itertuples():
        loop = row.real + 1j * row.imag
        assert len(loop) == POINTS
        # On a grid of 28 points a decade the sensitivity is at most its peak, and not far below where that is not sharp.
        peak = np.abs(1.0 / (1.0 + loop)).max()
        assert peak <= row.ms * (1.0 + 1e-5)
        assert row.ms > 3.0 or 0.93 * row.ms <= peak
        above = np.flatnonzero(np.abs(loop) > 1.0)
        if len(above):
            last = above[-1]
            assert row.frequency[last] <= row.crossover * (1.0 + 1e-5)
            # The crossover of a loop that depends on amplitude is the highest of all amplitudes, the curve that of one.
            assert row.case or row.crossover <= row.frequency[last + 1]


def test_margins_are_those_of_the_margin_model(outcome, margins):
    system = outcome.study.system
    model = MarginModel(system.cascade, system.nominal, system.timing, system.vehicle, Trim())
    found = model.evaluate(outcome.gains(outcome.tuned)[None])
    mine = margins[margins.point == outcome.names[outcome.tuned]]
    for i, row in enumerate(mine.itertuples()):
        assert row.stable == found.stable[0, i]
        if row.stable:
            assert row.phase_margin == pytest.approx(found.phase.value[0, i], rel=1e-9)
            assert row.case == model.cases[found.sensitivity.case[0, i]].label or found.sensitivity.case[0, i] < 0


def test_without_steady_flight_there_are_no_margins(outcome, monkeypatch):
    def none(_):
        raise InputError("no steady flight is found")

    monkeypatch.setattr(type(outcome.study), "margin_model", none)
    assert margin_table(outcome) is None


def test_loops_in_the_worst_steady_state_have_the_margins_that_are_judged():
    study = load_study(QUICKSTART)
    limits = [
        on_page(row, *SHOWN) for row in compare_known(problem_of(study, 1, None), np.array([study.default_row] * 2))
    ]
    default: Any = SimpleNamespace(study=study, gains=lambda _: study.default_row, names=["default"], tuned=0)
    table = written(worst_state_table(default, limits))
    tightest = tightest_margins(limits)["default"]
    assert set(table.state) == {tightest.default_state} and tightest.default_state != "hover"
    # The limit was read without these loops: in all states, and of all channels at once.
    assert tightest.label == "ms" and table.ms.max() == pytest.approx(tightest.default.value, rel=1e-6)
    assert worst_state_table(default, []) is None
