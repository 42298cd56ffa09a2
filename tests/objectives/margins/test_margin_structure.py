"""Blocks of the linearised loop: what is coupled is found as by another library."""

import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components

from objectives.margins.structure import _components


@pytest.mark.parametrize("links_each", [0.0, 0.3, 0.8, 1.5])
def test_components_are_those_of_scipy(links_each):
    draw = np.random.default_rng(8)
    for states in (1, 2, 7, 40):
        moves = draw.random((states, states)) < links_each / states
        links = draw.random((10, states)) < 0.5 * links_each / states
        graph = np.block([[moves, np.zeros((states, 5), bool)], [links[:5] | links[5:], np.zeros((5, 5), bool)]])
        count, label = _components(moves, links)
        expected, labels = connected_components(graph, directed=False)
        assert count == expected
        np.testing.assert_array_equal(label, labels)
