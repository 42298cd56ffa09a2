"""Intervals of identified vehicles on flights of a simulator that shares no code with the product."""

import numpy as np
import pytest

from benchmarks import identification
from benchmarks.identification import QUANTILE, identify_log, markdown, table_of
from tests.tuner.extensions.identification.independent_flights import draw_truths, fly

VEHICLES, SEED = 8, 77


@pytest.mark.slow
def test_intervals_hold_the_truth_of_an_independent_simulator():
    """Of 95.5 % that should, at least 85 %: numbers of a vehicle err together, so 144 count as some 40."""
    truth = draw_truths(np.random.default_rng(SEED), VEHICLES)
    recording = fly(truth, 12.0, SEED)
    outcomes = [identify_log(recording, truth, SEED, i) for i in range(VEHICLES)]
    identified = [entry for entry in outcomes if entry is not None]
    assert len(identified) >= VEHICLES - 1
    distances = np.abs([list(entry.distance.values()) for entry in identified])
    assert np.mean(distances <= QUANTILE) > 0.85
    assert np.median(distances) > 0.2, "intervals far too wide"


def test_the_table_counts_what_is_held_and_what_identified():
    outcomes = [
        identification.Outcome({"lag_up": distance}, {"lag_up": width}, unidentified)
        for distance, width, unidentified in (
            (0.5, 0.1, []),
            (-3.0, 0.2, []),
            (1.0, 0.3, ["lag_up"]),
            (2.5, 0.4, ["lag_up"]),
        )
    ]
    (row,) = table_of(outcomes)
    assert (row["covered"], row["identified"], row["covered_of_identified"]) == (0.5, 0.5, 0.5)
    assert row["median_half_width"] == pytest.approx(0.25)
    assert "5 logs" in markdown([row], 5, 1, [0.94]) and "1 refused" in markdown([row], 5, 1, [0.94])
    assert "| `lag_up` | 50 % | 50 % | 50 % | 0.25 |" in markdown([row], 5, 1, [0.94])
