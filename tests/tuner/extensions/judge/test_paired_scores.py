"""Position errors of two files on the same flights: the worst tenth is compared next to the mean."""

import numpy as np
import pytest

from objectives.metrics import parse
from objectives.metrics.address import CASCADE
from objectives.risk.differences import BETTER, WORSE
from tuner.extensions.judge.paired_scores import PairedScores
from tuner.extensions.judge.scenarios import FAILURE, POSITION

METRICS = [parse(name, CASCADE) for name in (FAILURE, "rms.tilt", POSITION)]


def rows_of(flights, change=1.0):
    """Rows of scores whose largest tenth is multiplied by a change."""
    before = np.random.default_rng(5).lognormal(0.0, 0.3, flights)
    after = before.copy()
    after[np.argsort(before)[-(flights // 10) :]] *= change
    tilt = np.ones(flights)
    scores = np.array([[np.zeros(flights), tilt, after], [np.zeros(flights), tilt, before]])
    return before, after, {row.label: row for row in PairedScores(METRICS, scores, 1).rows}


def change_of(row):
    """Change of a row as a share."""
    assert row.difference is not None
    return row.difference.value


@pytest.mark.parametrize(("change", "word"), [(1.2, WORSE), (0.9, BETTER)])
def test_the_worst_tenth_has_a_word_of_its_own(change, word):
    before, after, rows = rows_of(250, change)
    assert list(rows) == ["rms.tilt", "rms.position", "cvar 0.9 of rms.position"]
    tail = rows["cvar 0.9 of rms.position"]
    worst_before, worst_after = np.sort(before)[-25:].mean(), np.sort(after)[-25:].mean()
    assert (tail.before, tail.after) == pytest.approx((worst_before, worst_after), rel=1e-12)
    assert change_of(tail) == pytest.approx(worst_after / worst_before - 1.0, rel=1e-9)
    assert tail.verdict == word
    # The mean of all flights moves by a tenth of that, less than a difference that matters.
    assert change_of(rows["rms.position"]) == pytest.approx(change**0.1 - 1.0, rel=1e-9)
    assert rows["rms.position"].verdict not in (WORSE, BETTER)


def test_few_flights_have_no_tail():
    assert list(rows_of(79)[2]) == ["rms.tilt", "rms.position"]


def test_an_interval_of_two_flights_is_finite_and_decides_nothing():
    """Ratios of 1e-60 and 1e60 have an interval whose exponential is beyond any number of a computer."""
    tilt = np.array([[1e-60, 1e60], [1.0, 1.0]])
    scores = np.stack([np.zeros((2, 2)), tilt, np.ones((2, 2))], axis=1)
    row = {row.label: row for row in PairedScores(METRICS, scores, 1).rows}["rms.tilt"]
    assert row.difference is not None and np.isfinite(list(row.difference)).all()
    assert row.verdict not in (WORSE, BETTER)
