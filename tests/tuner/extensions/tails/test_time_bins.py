"""Bins of time beside their definition."""

import numpy as np
import pytest

from tests.tuner.extensions.tails.estimation.closed_forms import Closed
from tuner.extensions.tails.estimation.design_point import find_design_point
from tuner.extensions.tails.normals import NormalSpace
from tuner.extensions.tails.time_bins import BINS, TimeBins

STEPS = 200


def bins():
    def draw(source):
        source("vehicle", 0).uniform(size=3)
        source("air", 0).standard_normal((STEPS, 2))
        source("sensors", 0).standard_normal((BINS, 2))

    space = NormalSpace.of(draw)
    return space, TimeBins(space)


def test_a_process_has_a_start_and_bins_and_everything_else_each_number():
    space, found = bins()
    assert space.dimension == 3 + 2 * STEPS + 2 * BINS
    assert found.size == 3 + 2 * (1 + BINS) + 2 * BINS


def test_the_vectors_are_orthonormal():
    _, found = bins()
    basis = found.expanded(np.eye(found.size))
    assert basis @ basis.T == pytest.approx(np.eye(found.size))
    assert found.projected(basis) == pytest.approx(np.eye(found.size))


def test_what_is_constant_in_bins_is_left_as_it_is_and_the_start_stands_alone():
    space, found = bins()
    vector = np.zeros((1, space.dimension))
    vector[0, space.parts["air"].start] = 3.0
    assert found.expanded(found.projected(vector)) == pytest.approx(vector)
    later = np.zeros((1, space.dimension))
    later[0, space.parts["air"].start + 2 * 100] = 3.0
    assert np.max(found.expanded(found.projected(later))) < 2.0


def test_of_one_part_all_else_stays_at_0():
    space, found = bins()
    air = TimeBins(space, part="air")
    assert air.size == 2 * (1 + BINS)
    vectors = air.expanded(np.eye(air.size))
    outside = np.ones(space.dimension, dtype=bool)
    outside[space.parts["air"]] = False
    assert not vectors[:, outside].any()
    assert vectors @ vectors.T == pytest.approx(np.eye(air.size))
    assert air.projected(vectors) == pytest.approx(np.eye(air.size))
    # The bins are those of the whole.
    assert found.expanded(found.projected(vectors)) == pytest.approx(vectors)


def test_noise_within_bins_is_no_part_of_a_design_point():
    steps, normals = 2000, np.random.default_rng(1).standard_normal(2000)
    direction = np.where(np.arange(steps) >= 1900, 0.1, 0.0)
    limit = Closed(steps, lambda z: [np.sum(z * direction, axis=1) / 4.0])
    space = NormalSpace.of(lambda source: source("air", 0).standard_normal((steps, 1)))
    point = find_design_point(limit, 0, TimeBins(space), normals + 4.5 * direction)
    assert point is not None and limit.values(point[None])[0, 0] >= 1.0
    assert np.linalg.norm(point) == pytest.approx(4.0, abs=0.03)
