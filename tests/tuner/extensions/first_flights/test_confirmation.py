"""Rank correlation against SciPy's, and gaps of flights whose truth is known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.stats import spearmanr

from objectives.metrics import parse
from objectives.problem import Objective
from objectives.risk import Risk
from tuner.extensions.first_flights.confirmation import (
    PairedFlights,
    confirmed_points,
    confirmed_quantities,
    rank_correlation,
)


@pytest.mark.parametrize("ties", [False, True])
def test_the_rank_correlation_is_scipys(ties):
    draw = np.random.default_rng(3)
    peer: Any = spearmanr
    for _ in range(20):
        first, second = draw.normal(size=(2, 9))
        if ties:
            first, second = np.round(first), np.round(second)
        assert rank_correlation(first, second) == pytest.approx(peer(first, second).statistic)


def flown(gap, shape=(4, 1, 16)):
    draw = np.random.default_rng(5)
    model = np.arange(1.0, 1.0 + shape[0])[:, None, None] + draw.lognormal(size=shape)
    lost = np.zeros((shape[0], shape[2]), dtype=bool)
    quantities = (Objective(parse("rms.attitude"), Risk("mean")),)
    firmware = model + gap + 0.01 * draw.normal(size=shape)
    names = tuple(f"p{k}" for k in range(shape[0]))
    return PairedFlights(
        names, quantities, firmware, model, lost, lost, np.repeat("gusts", shape[2]), firmware[0] + 1e-3, 1
    )


@pytest.mark.parametrize("gap", [-0.3, 0.0, 0.2])
def test_a_known_gap_is_found_by_pairs(gap):
    """Flights differ by their air a hundred times more than firmware and model do; paired, the interval is narrow all the same."""
    found: Any = confirmed_quantities(flown(gap))[0]
    assert found.gap.low < gap + 0.006 and found.gap.high > gap - 0.006
    assert found.gap.high - found.gap.low < 0.02
    assert found.correlation.value == 1.0
    assert found.jitter == pytest.approx(1e-3)
    assert found.relative == pytest.approx(
        found.gap.value / np.mean([point.values[0].model for point in confirmed_points(flown(gap))])
    )


def test_two_finalists_have_no_ranks():
    (found,) = confirmed_quantities(flown(0.1, (2, 1, 8)))
    assert found.correlation.value is None and found.gap.value == pytest.approx(0.1, abs=0.02)


def test_the_interval_of_a_gap_holds_it_in_95_of_100():
    held = []
    for seed in range(60):
        draw = np.random.default_rng(seed)
        model = 1.0 + draw.lognormal(size=(3, 1, 40))
        lost = np.zeros((3, 40), dtype=bool)
        firmware = model + 0.2 + 0.1 * draw.standard_normal((1, 1, 40)) * np.ones((3, 1, 1))
        quantities = (Objective(parse("rms.attitude"), Risk("mean")),)
        flights = PairedFlights(
            ("a", "b", "c"), quantities, firmware, model, lost, lost, np.repeat("g", 40), None, seed
        )
        gap: Any = confirmed_quantities(flights)[0].gap
        held.append(gap.low <= 0.2 <= gap.high)
    assert 0.86 < np.mean(held), "four standard deviations of 60 are 11 %"


def test_lost_flights_are_counted_where_they_were_lost():
    flights = flown(0.1)
    firmware, model = np.zeros((4, 16), dtype=bool), np.zeros((4, 16), dtype=bool)
    firmware[1, :3], model[2, :5] = True, True
    points = confirmed_points(replace(flights, lost_firmware=firmware, lost_model=model))
    assert [(point.lost_firmware, point.lost_model) for point in points] == [(0, 0), (3, 0), (0, 5), (0, 0)]
