"""Design points against the closed form of linear limits."""

import numpy as np
import pytest

from objectives.tails.design_points import descend, typical_failure
from objectives.tails.hidden_modes import split_off
from objectives.tails.splitting import run_together
from tests.objectives.tails.closed_forms import Closed, half_space


@pytest.mark.parametrize("dimension", [2, 30])
def test_a_descent_ends_at_the_closest_failure(dimension):
    direction = np.linspace(1.0, 2.0, dimension) / np.linalg.norm(np.linspace(1.0, 2.0, dimension))
    limit = Closed(dimension, lambda u: [np.sum(u * direction, axis=1) / 4.0])
    start = 4.5 * direction + np.random.default_rng(0).standard_normal(dimension)
    [point] = run_together(limit, [descend(0, start)])
    assert point is not None
    assert point == pytest.approx(4.0 * direction, abs=0.1)
    assert limit.values(point[None])[0, 0] >= 1.0


def test_a_demand_without_slope_is_followed_along_the_ray():
    limit = Closed(2, lambda u: [np.floor(np.linalg.norm(u, axis=1)) / 4.0])
    [point] = run_together(limit, [descend(0, np.array([5.0, 5.0]))])
    assert point is not None and 4.0 <= np.linalg.norm(point) < 4.5


def test_noise_of_many_dimensions_shrinks():
    # 2000 numbers of which the last hundred decide.
    direction = np.where(np.arange(2000) >= 1900, 0.1, 0.0)
    limit = Closed(2000, lambda u: [np.sum(u * direction, axis=1) / 4.0])
    start = np.random.default_rng(1).standard_normal(2000) + 4.5 * direction
    [point] = run_together(limit, [descend(0, start)])
    assert point is not None
    assert np.linalg.norm(start) > 44.0 and np.linalg.norm(point) < 12.0
    assert limit.values(point[None])[0, 0] >= 1.0


def test_no_failure_on_the_ray_is_no_design_point():
    limit = half_space(4.0, 2)
    assert run_together(limit, [descend(0, np.array([-1.0, 0.0]))]) == [None]


def test_failures_in_two_directions_are_not_averaged():
    rng = np.random.default_rng(2)
    failures = np.concatenate([4.0 * np.eye(5)[[0] * 30], -4.0 * np.eye(5)[[0] * 20]])
    mean = typical_failure(failures + 0.3 * rng.standard_normal(failures.shape))
    assert mean[0] == pytest.approx(4.0, abs=0.2)


def test_directions_of_one_kind_are_not_split():
    turns = np.linspace(0.0, 0.8, 5)
    directions = np.column_stack([np.cos(turns), np.sin(turns)])
    assert split_off(0, directions) is None
    sectors = split_off(0, np.concatenate([directions, -directions[:2]]))
    assert sectors is not None
    near, far = sectors
    assert len(near.near) == len(far.far) == 5 and len(far.near) == 2
