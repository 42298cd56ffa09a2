"""The exact judges of the benchmark against counts of their own limit functions, where these are not rare."""

import numpy as np
import pytest
from scipy.stats import binomtest

from benchmarks.tails.judges import FirstPassage, HiddenMode, OppositeModes, Oscillator


@pytest.mark.parametrize(
    "judge",
    [FirstPassage(3.0), Oscillator(3.0), OppositeModes(2.0, 2.5), HiddenMode(2.0)],
    ids=lambda j: type(j).__name__,
)
def test_counts_agree_with_the_exact_probability(judge):
    rows = 40_000
    failed = np.count_nonzero(judge.values(np.random.default_rng(5).standard_normal((rows, judge.dimension))) >= 1.0)
    assert binomtest(failed, rows, judge.probability).pvalue > 1e-3


def test_the_sampled_processes_have_unit_variance():
    for judge in (FirstPassage(1.0, dimension=1), Oscillator(1.0, dimension=2)):
        exact = {1: 0.158655, 2: judge.probability}[judge.dimension]
        assert judge.probability == pytest.approx(exact, abs=1e-5)
