"""`python -m benchmarks.cuda`: what it does where nothing can be measured, and the flights that it makes."""

import sys

import numpy as np
import pytest

from benchmarks import cuda as benchmark
from plant.backends.flyer import to_lanes
from tuner.extensions.cuda.card import NO_CARD


def test_without_a_card_it_says_so_and_measures_nothing(monkeypatch, capsys):
    monkeypatch.setattr(benchmark, "missing", lambda: NO_CARD)
    monkeypatch.setattr(sys, "argv", ["benchmarks.cuda", "--json"])
    with pytest.raises(SystemExit) as ended:
        benchmark.main()
    assert ended.value.code == f"{NO_CARD}; nothing was measured"
    assert capsys.readouterr().out == ""


def test_the_first_block_holds_the_first_scenarios():
    inputs = benchmark.scenarios(18, 1.2)
    head = benchmark.first_block(inputs, 16)
    assert head.count == 16 and len(head.disturbances) == 1
    assert np.array_equal(head.disturbances, inputs.disturbances[:1])
    assert to_lanes(np.zeros((18, 1))).shape[0] == len(inputs.dynamics) == 2


def test_candidates_differ_by_at_most_a_hundredth():
    gains = benchmark.candidates(5)
    np.testing.assert_allclose(gains[[0, 4]], [0.995 * gains[2], 1.005 * gains[2]], rtol=1e-12)
