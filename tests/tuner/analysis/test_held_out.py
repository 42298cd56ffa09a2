"""Who is on the front how surely, and what picking on held-out values does to them: by hand and by simulation."""

import numpy as np
import pytest

from objectives.metrics import parse
from objectives.problem import Constraint, Objective
from objectives.risk import Risk
from tests.objectives.risk.resampling import bootstrap_interval
from tuner.analysis.held_out import compared_row, share_non_dominated
from tuner.documents.parts import Estimate, SampledValue
from tuner.search.front import non_dominated, pick


def test_the_share_of_resamples_on_the_front_by_hand():
    # Resamples by column; two objectives. Row 1 is beaten by row 0 in the last two, row 2 never, for it is best in b.
    a = np.array([[1.0, 1.0, 1.0, 1.0], [0.5, 0.5, 2.0, 2.0], [3.0, 3.0, 3.0, 3.0]])
    b = np.array([[5.0, 5.0, 5.0, 5.0], [6.0, 6.0, 6.0, 6.0], [1.0, 1.0, 1.0, 1.0]])
    assert share_non_dominated(np.stack([a, b], axis=1)).tolist() == [1.0, 0.5, 1.0]
    assert share_non_dominated(np.empty((0, 2, 4))).tolist() == []
    # Equal rows do not dominate each other.
    assert share_non_dominated(np.ones((2, 2, 5))).tolist() == [1.0, 1.0]


def test_the_pick_is_flattered_on_what_it_was_picked_by_and_not_on_fresh_flights():
    # 24 equally good points on the line a + b = 2, flown 200 times: the knee is the luckiest sum. The mean of 24 maxima of
    # independent sums is 1.95 standard errors of one (order statistics), 1.38 for each objective.
    rng, places, mean = np.random.default_rng(8), np.linspace(0.0, 1.0, 24), Risk("mean")
    truth = np.stack([1.0 + places, 2.0 - places], axis=1)
    hits, flattery = np.zeros((2, 200, 2)), []
    for k in range(200):
        held_out, fresh = (truth[..., None] + rng.standard_normal((24, 2, 200)) for _ in range(2))
        values = held_out.mean(axis=2)
        front = np.flatnonzero(non_dominated(values))
        row = int(front[pick("knee", values[front], ["a", "b"])[0]])
        flattery.append((truth[row] - values[row]).mean(axis=0) * np.sqrt(200.0))
        for i, scores in enumerate((held_out, fresh)):
            low, high = bootstrap_interval(scores[row], mean, rng, 200)
            hits[i, k] = (low <= truth[row]) & (truth[row] <= high)
    picked, confirmed = hits.mean(axis=(1, 2))
    # 400 intervals: four standard errors of 0.95 are 0.044.
    assert confirmed > 0.95 - 0.044 and picked < 0.85
    assert np.mean(flattery, axis=0) == pytest.approx(1.38, abs=0.25)


@pytest.mark.parametrize(
    ("low", "value", "high", "verdict"),
    [
        (-0.3, -0.2, -0.1, "better"),
        (0.1, 0.2, 0.3, "worse"),
        # However sure, where it is small.
        (4e-6, 5e-6, 6e-6, "no practical difference"),
        (-0.1, 0.1, 0.3, "not distinguishable"),
        # An end at zero leaves nothing out.
        (-0.2, -0.1, 0.0, "not distinguishable"),
        (0.0, 0.0, 0.0, "no practical difference"),
    ],
)
def test_a_verdict_is_what_the_whole_interval_allows(low, value, high, verdict):
    quantity = Objective(parse("travel"), Risk("mean"))
    default, tuned = Estimate(1.0, 0.9, 1.1), Estimate(1.0 + value, 0.9 + value, 1.1 + value)
    assert compared_row(quantity, default, tuned, SampledValue(value, low, high)).verdict == verdict


@pytest.mark.parametrize(("value", "verdict"), [(0.9, "kept"), (1.0, "kept"), (1.0001, "broken")])
def test_a_constraint_is_judged_by_its_value_and_not_by_the_difference(value, verdict):
    quantity = Objective(parse("travel"), Risk("mean"))
    better = SampledValue(-1.0, -2.0, -0.5)
    compared = compared_row(
        quantity, Estimate(2.0, 1.5, 2.5), Estimate(value, value - 0.5, value + 0.5), better, Constraint(quantity, 1.0)
    )
    assert compared.verdict == verdict
