"""The loop by hand in C, which the speed of the lanes is held against, flies what the model flies."""

import numpy as np
import pytest

from benchmarks.course import draw, loop
from benchmarks.peers import ceiling, vectorised
from plant.backends.lane_layout import result_rows
from plant.records import flatten

SCENARIOS, PERIODS = 4, 100


@pytest.mark.parametrize(
    "defines",
    [pytest.param((), id="model's algebra"), pytest.param(("-DSHORTCUTS=1",), id="shortcuts", marks=pytest.mark.slow)],
)
@pytest.mark.skipif(ceiling.compiler() is None, reason="no C compiler")
def test_c_flies_what_the_model_flies(tmp_path, defines):
    """All 72 results of each flight: both are float64, and differ in the order of their sums alone."""
    course = draw(SCENARIOS, duration=0.5)
    flights = vectorised.prepare(course, SCENARIOS, PERIODS, 1, tmp_path)()
    model = np.stack([np.broadcast_to(leaf, (1, SCENARIOS))[0] for leaf in flatten(flights)], axis=-1)
    wanted = model[:, result_rows(loop())]
    given = ceiling.flights(course, SCENARIOS, PERIODS, 1, tmp_path, *defines)()[0]
    np.testing.assert_allclose(given, wanted, rtol=1e-9, atol=1e-9)
    assert np.ptp(wanted, axis=0)[0] > 0.0
    assert wanted[0, -2:].tolist() == pytest.approx([0.0, PERIODS * 0.004])


@pytest.mark.skipif(ceiling.compiler() is None, reason="no C compiler")
def test_loading_it_leaves_the_smallest_numbers_alone(tmp_path):
    ceiling.build(tmp_path)
    assert float("5e-324") > 0.0 and 0.5 * np.float64(1e-323) > 0.0
