"""Run, comparison and judge have one word for the same flights."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from objectives.metrics import parse
from objectives.problem import Objective
from objectives.risk import Risk
from plant.seeds import generator
from tuner.analysis.held_out import compare
from tuner.experiments.compare.statistics import compare_all
from tuner.extensions.judge.paired_scores import PairedScores
from tuner.study.comparison import Quantity

TRAVEL, FAILURE = (Objective(parse(name), Risk("mean")) for name in ("travel", "failure"))
FLIGHTS = 256


def flights(ratio, spread, lost=(0, 0)):
    """Return scores (files, metrics, flights), failure first: the earlier file, then one with a ratio of its travel."""
    rng = generator(1, "test/same-word", 0)
    air = np.exp(0.1 * rng.standard_normal(FLIGHTS))
    chance = np.exp(spread * rng.standard_normal((2, FLIGHTS)))
    travel = air * chance * np.array([[1.0], [ratio]])
    failed = np.stack([np.arange(FLIGHTS) < 0, np.arange(FLIGHTS) < 0]).astype(float)
    for row, count in zip(failed, lost, strict=True):
        row[:count] = 1.0
    return np.stack([failed, travel], axis=1)


def words_of(scores):
    """Return the words of run, comparison and judge on failure and travel."""
    origin = np.full(FLIGHTS, "gusts")
    problem: Any = SimpleNamespace(objectives=(FAILURE, TRAVEL), constraints=(), quantities=(FAILURE, TRAVEL))
    flown: Any = SimpleNamespace(origin=origin, samples=lambda i, _: scores[:, i])
    contested: Any = SimpleNamespace(scores=scores, origin=origin, samples=lambda i, _: scores[:, i])
    quantities = (Quantity(FAILURE, "objective"), Quantity(TRAVEL, "objective"))
    judged = PairedScores([FAILURE.metric, TRAVEL.metric], scores[::-1], 1)
    return (
        [row.verdict for row in compare(problem, flown, 1)],
        [entry.word for entry in compare_all(contested, quantities, 1).differences],
        [judged.loss, judged.rows[0].verdict],
    )


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ((0.99, 0.001), "no practical difference"),
        ((0.9, 0.1), "better"),
        ((1.1, 0.1), "worse"),
        ((0.97, 0.001), "better"),
        ((1.0, 0.5), "not distinguishable"),
        ((0.982, 0.03), "not distinguishable"),
    ],
)
def test_the_same_flights_have_the_same_word_everywhere(given, word):
    run, compared, judged = words_of(flights(*given))
    assert run[1] == compared[1] == judged[1] == word


@pytest.mark.parametrize(
    ("lost", "word"),
    [((0, 0), "not distinguishable"), ((0, 9), "worse"), ((9, 0), "better"), ((0, 4), "not distinguishable")],
)
def test_lost_flights_have_the_same_word_everywhere(lost, word):
    run, compared, judged = words_of(flights(1.0, 0.01, lost))
    assert run[0] == compared[0] == judged[0] == word


def test_the_intervals_of_a_table_end_where_a_metric_does():
    # Flights of 300 s, of which few never settle: resamples without them have next to no error, and the upper end is anywhere.
    settling = Objective(parse("settling.x"), Risk("mean"))
    rng = generator(1, "test/settling", 0)
    default = np.where(np.arange(FLIGHTS) < 3, 300.0, 15.0 + 0.01 * rng.standard_normal(FLIGHTS))
    tuned = 12.0 + 0.01 * rng.standard_normal(FLIGHTS)
    scores = np.stack([default, tuned])[:, None]
    problem: Any = SimpleNamespace(objectives=(settling,), constraints=(), quantities=(settling,))
    flown: Any = SimpleNamespace(origin=np.full(FLIGHTS, "steps"), samples=lambda i, _: scores[:, i])
    free: Any
    held: Any
    lost: Any
    (free,), (held,) = compare(problem, flown, 1), compare(problem, flown, 1, costs=np.array([600.0]))
    assert free.default.high > 300.0 == held.default.high
    assert held.tuned == free.tuned and held.difference.low >= -300.0
    # A lost flight costs up to twice as much, and so may the end.
    scores[0, 0, 0] = 600.0
    (lost,) = compare(problem, flown, 1, costs=np.array([600.0]))
    assert 300.0 < lost.default.high <= 600.0
