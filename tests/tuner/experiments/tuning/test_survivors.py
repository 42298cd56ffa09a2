"""Few flights first: who survives a search, what survivors fly, and that nobody else may be recommended."""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from plant.quadrotor.scenarios import SEARCH
from tests.tables import read_frame
from tests.tuner.conftest import run_small
from tests.tuner.in_process import tuner
from tuner.experiments.planning.counts import search_flights
from tuner.experiments.tuning.problem import batches
from tuner.experiments.tuning.survivors import MAX_SURVIVORS, joined, layers, surviving
from tuner.search.front import feasible_front, hypervolume, non_dominated

FIRST, ALL = 4, 6


@pytest.fixture(scope="module")
def staged(tmp_path_factory):
    folder = tmp_path_factory.mktemp("survivors") / "r"
    return run_small(folder, scenario__0__search=ALL, search__first=FIRST), folder


def test_every_candidate_flies_the_first_and_survivors_the_others(staged):
    outcome, folder = staged
    survivors, tried = outcome.survivors, len(outcome.archive.points)
    assert outcome.generations[-1].flights == FIRST * tried
    assert survivors.flights == (ALL - FIRST) * len(survivors.candidates)
    flown = pd.concat([read_frame(file) for file in (folder / "flights").glob("*.npz")])
    assert len(flown[flown.stream == SEARCH]) == FIRST * tried + survivors.flights
    assert outcome.flights_made == outcome.flights
    assert outcome.generations[-1].flights + survivors.flights <= search_flights(outcome.study)


def test_survivors_are_judged_on_all_flights(staged):
    outcome, _ = staged
    survivors = outcome.survivors
    again = outcome.problem.evaluate(
        outcome.archive.points[survivors.candidates], batches(outcome.study, SEARCH), fly_all=True
    )
    assert np.array_equal(survivors.evaluation.scores, again.scores)
    # Means over other layouts are rounded otherwise.
    for name in ("values", "violations", "failures"):
        np.testing.assert_allclose(getattr(survivors.evaluation, name), getattr(again, name), rtol=1e-12, atol=1e-15)
    front = survivors.candidates[feasible_front(again.values, again.violations)]
    assert set(outcome.candidates) <= set(front)


def test_each_flight_counts_once_in_the_share_of_those_that_are_lost(staged):
    """Of four flights first and two later the later ones are lost: 2 of 6."""
    seen = staged[0].generations[0].evaluation
    none, later = np.zeros(len(seen.values)), slice(ALL - FIRST)
    first = replace(seen, failures=none)
    rest = replace(seen, failures=none + 1.0, scores=seen.scores[..., later], origin=seen.origin[later])
    both = joined(staged[0].problem, first, rest)
    np.testing.assert_allclose(both.failures, 2.0 / 6.0, rtol=1e-12)
    assert both.scores.shape[-1] == ALL and both.lost.tolist() == [2 * flown for flown in seen.flown]


def test_the_front_survives_and_what_is_surely_beaten_does_not(staged):
    outcome, _ = staged
    seen = outcome.generations[0].evaluation
    for entry in outcome.generations:
        kept = surviving(outcome.problem, entry.evaluation, 1)
        assert set(feasible_front(entry.evaluation.values, entry.evaluation.violations)) <= set(kept)
    # Ten times as bad in every flight: beaten whatever flights are drawn.
    row = int(feasible_front(seen.values, seen.violations)[0])
    scores, values = np.repeat(seen.scores[[row]], 2, axis=0), np.repeat(seen.values[[row]], 2, axis=0)
    scores[1, :2] *= 10.0
    values[1] *= 10.0
    pair = type(seen)(
        values,
        np.zeros((2, seen.violations.shape[1])),
        np.zeros(2),
        scores,
        seen.origin,
        np.zeros((2, 0)),
        np.ones(2, dtype=bool),
    )
    assert surviving(outcome.problem, pair, 1).tolist() == [0]


def test_a_front_of_many_is_thinned_by_hypervolume(staged):
    """Of a front whose points crowd at one end, those stay that dominate most."""
    outcome, _ = staged
    seen = outcome.generations[0].evaluation
    angle = 0.5 * np.pi * np.linspace(0.0, 1.0, 4 * MAX_SURVIVORS) ** 6
    values = np.concatenate([[[1.0, 1.0]], np.stack([1.0 - np.sin(angle), 1.0 - np.cos(angle)], axis=1)])
    count = len(values)
    crowd = replace(
        seen,
        values=values,
        excess=np.zeros((count, seen.excess.shape[1])),
        failures=np.zeros(count),
        scores=np.repeat(seen.scores[:1], count, axis=0),
        requirements=np.zeros((count, 0)),
        counted=None,
        failed=None,
        flown=np.ones(count, dtype=bool),
    )
    chosen = values[surviving(outcome.problem, crowd, 1)]
    assert len(chosen) == MAX_SURVIVORS
    dominated = hypervolume(chosen, values[0]) / hypervolume(values, values[0])
    along = values[1:][np.argsort(values[1:, 0])]
    evenly_spaced = along[np.unique(np.linspace(0, len(along) - 1, MAX_SURVIVORS).round().astype(int))]
    assert dominated > 0.995 > hypervolume(evenly_spaced, values[0]) / hypervolume(values, values[0])


@pytest.mark.slow
def test_a_scenario_may_have_no_flights_left_for_survivors(tmp_path, monkeypatch, capsys):
    """Its quantities have no value of the other flights alone; those of all flights are judged."""
    small = ["search.generations=2", "search.population=8", "scenario.0.search=4", "scenario.0.held_out=16"]
    options = [word for value in small for word in ("--set", value)]
    code, _, error = tuner(
        monkeypatch, capsys, "run", "heater", *options, "--set", "scenario.1.held_out=16", "--out", tmp_path / "r"
    )
    assert code == 0, error
    assert np.isfinite(pd.read_csv(tmp_path / "r" / "front.csv").filter(like="held_out")).all(axis=None)


def test_the_words_say_how_many_survived(staged):
    outcome, folder = staged
    said = f"Of {len(outcome.archive.points)} candidates {len(outcome.survivors.candidates)} survived"
    for name in ("summary.json", "report.html"):
        assert said in (folder / name).read_text()


def test_the_words_say_up_to_where_the_front_counts(tmp_path):
    folder = tmp_path / "r"
    outcome = run_small(folder, search__algorithm="gaussian_process")
    text = json.loads((folder / "summary.json").read_text())["search"]
    values = re.search(
        r"The front counts in full up to \S+ (\S+) .*? and \S+ (\S+) .*, beyond that with a weight of 0.15", text
    )
    assert values is not None, text
    # A tenth beyond the default, or further: two spreads of what was tried.
    front, default = outcome.archive.values[outcome.archive.front()], outcome.archive.values[0]
    least = default + 0.1 * (default - front.min(axis=0))
    assert np.all(np.array([float(value) for value in values.groups()]) >= 0.99 * least)


def test_layers_are_fronts_taken_away_one_after_the_other():
    values = np.random.default_rng(1).random((60, 2))
    found = layers(values)
    for k in range(found.max() + 1):
        left = np.flatnonzero(found >= k)
        assert np.array_equal(left[non_dominated(values[left])], np.flatnonzero(found == k))
