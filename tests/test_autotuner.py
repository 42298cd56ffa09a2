"""Gains of our search beside those of another tool's autotuner, see `benchmarks.autotuner`."""

import pytest

from benchmarks.autotuner import CASES, autotuned, judged, ours
from tests.clients import client


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=str)
def test_the_error_is_that_of_the_autotuner_at_its_own_peaks_and_limits_are_kept(case):
    client("pycollimator")
    reached = judged(case, autotuned(case))
    beside = judged(case, ours(case, reached.ms, max(reached.mt, case.peak)))
    # A sampled loop of 2 kHz bears 0.3 % less than the continuous one that judges; the search ends within 0.1 %.
    assert beside.ms <= reached.ms and beside.error <= 1.004 * reached.error
    kept = judged(case, ours(case, case.peak, case.peak))
    assert max(kept.ms, kept.mt) <= case.peak < reached.ms
