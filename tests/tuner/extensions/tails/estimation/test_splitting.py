"""Replicas are unbiased, whatever the chains do, and the same bits in any company."""

import numpy as np
import pytest
from scipy.stats import chi2, norm

from plant.seeds import generator
from tests.tuner.extensions.tails.estimation.closed_forms import Closed, corner, half_space
from tuner.extensions.tails.estimation.splitting import (
    CHAIN,
    Ladder,
    _joined,
    climb,
    next_level,
    replicate,
    run_together,
)

CURVE = np.array([0.5, 0.8, 1.0])


def replicas(limit, ladders, numbers, curve=CURVE):
    streams = (generator(7, "tail/replica", number) for number in numbers)
    return run_together(
        limit,
        [
            replicate(number, limit.dimension, ladders, curve, stream)
            for number, stream in zip(numbers, streams, strict=True)
        ],
    )


def error_of(values, exact):
    """Error of a mean in its standard errors."""
    return (np.mean(values) - exact) / (np.std(values, ddof=1) / np.sqrt(len(values)))


# Steps of 1 forget at once, of 0.05 hardly move at all; levels are uneven, and seeds few.
@pytest.mark.slow
@pytest.mark.parametrize("step", [1.0, 0.4, 0.05])
@pytest.mark.parametrize("levels", [(0.4, 0.8), (0.3, 0.35, 0.9)])
def test_the_mean_of_replicas_is_the_probability(step, levels):
    ladder = Ladder(0, levels, (step,) * len(levels), 1.0, 20)
    done = replicas(half_space(3.0), (ladder,), range(250))
    values = np.array([replica.curve for replica in done])
    for column, level in zip(values.T, CURVE, strict=True):
        assert abs(error_of(column, norm.sf(3.0 * level))) < 4.0
    assert [replica.probability for replica in done] == [replica.ladders[0] for replica in done]


def test_a_failure_on_two_ladders_counts_once():
    ladders = (Ladder(0, (0.5,), (0.5,), 1.0, 20), Ladder(1, (0.4, 0.7), (0.5, 0.5), 1.0, 10))
    done = replicas(corner(1.5, 2.0), ladders, range(250))
    values = np.array([replica.curve for replica in done])
    for column, level in zip(values.T, CURVE, strict=True):
        either = 1.0 - norm.cdf(1.5 * level) * norm.cdf(2.0 * level)
        assert abs(error_of(column, either)) < 4.0
    for place, distance in enumerate((1.5, 2.0)):
        assert abs(error_of([replica.ladders[place] for replica in done], norm.sf(distance))) < 4.0


def test_the_states_of_a_level_are_drawn_above_it():
    # A radius in three dimensions: the share beyond each level is a chi-square tail.
    limit = Closed(3, lambda u: [np.sqrt(np.sum(u * u, axis=1)) / 5.0])
    ladder = Ladder(0, (0.6, 0.8), (0.4, 0.4), 1.0, 50)
    done = replicas(limit, (ladder,), range(200), np.array([0.7, 0.9, 1.0]))
    values = np.array([replica.curve for replica in done])
    for column, level in zip(values.T, (0.7, 0.9, 1.0), strict=True):
        assert abs(error_of(column, chi2.sf((5.0 * level) ** 2, 3))) < 4.0


def test_replicas_are_the_same_bits_in_any_order_and_company():
    ladder = Ladder(0, (0.4, 0.8), (0.5, 0.5), 1.0, 10)
    together = replicas(half_space(3.0), (ladder,), range(6))
    assert together == [replicas(half_space(3.0), (ladder,), [number])[0] for number in range(6)]
    assert together[::-1] == replicas(half_space(3.0), (ladder,), range(5, -1, -1))


def test_a_replica_that_dies_out_is_zero_and_ends():
    ladder = Ladder(0, (0.2, 0.6), (0.5, 0.5), 1.0, 10)
    limit = Closed(2, lambda u: [np.minimum(u[:, 0] / 3.0, 0.5)])
    [replica] = replicas(limit, (ladder,), [0])
    assert replica.probability == replica.ladders[0] == 0.0
    assert replica.evaluations == 10 * CHAIN + 10 * (CHAIN - 1)


def test_the_pilot_climbs_to_the_failure_and_says_how():
    limit = half_space(4.5)
    [ascent] = run_together(limit, [climb(0, 5, 50, 1e-9, generator(1, "tail/pilot", 0))])
    assert ascent.ladder.target == 1.0 and not ascent.is_stalled
    assert 0.2 < ascent.probability / norm.sf(4.5) < 5.0
    assert np.all(np.diff(ascent.ladder.levels) > 0.0) and np.all(ascent.states[:, 0] >= 4.5)
    # Moves shrink as the part of the space does that they must stay in.
    assert np.all(np.diff(ascent.ladder.steps) < 0.0) and ascent.ladder.steps[-1] > 0.1


@pytest.mark.parametrize(
    ("values", "before", "level"),
    [
        ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], -np.inf, 8.0),
        ([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0], 1.0, 2.0),
        # The quantile is tied with the level before.
        ([1.0] * 19 + [5.0], 1.0, 5.0),
        ([1.0] * 20, 1.0, None),
    ],
)
def test_tied_values_give_the_next_larger_level(values, before, level):
    assert next_level(np.array(values), before) == level


def test_of_a_pilot_that_is_stuck_few_ties_are_held(monkeypatch):
    sizes = []

    def joined(*given):
        made = _joined(*given)
        sizes.append(len(made.survivors.states))
        return made

    monkeypatch.setattr("tuner.extensions.tails.estimation.splitting._joined", joined)
    # No move comes beyond a demand of 0.5.
    limit = Closed(3, lambda u: [np.minimum(u[:, 0] / 4.0, 0.5)])
    [ascent] = run_together(limit, [climb(0, 3, 20, 1e-6, np.random.default_rng(1))])
    assert ascent.is_stalled and max(sizes) <= 4 * 20
