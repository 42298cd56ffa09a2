"""Design points beside those that are known in closed form."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from tests.tuner.extensions.tails.estimation.closed_forms import Closed, half_space
from tuner.extensions.tails.estimation.design_point import Basis, WholeSpace, find_design_point, search_evaluations
from tuner.extensions.tails.estimation.hidden_modes import split_off

Array = np.ndarray

D, BETA = 60, 4.0
ALPHA = np.arange(1.0, D + 1) / np.linalg.norm(np.arange(1.0, D + 1))


@dataclass
class Limit:
    """Limit function of demands."""

    demands: tuple[Callable[[Array], Array], ...]
    dimension: int = D

    @property
    def modes(self) -> tuple[str, ...]:
        return tuple(map(str, range(len(self.demands))))

    def values(self, normals: Array) -> Array:
        return np.stack([demand(normals) for demand in self.demands], axis=-1)


@dataclass
class First:
    """The first coordinates."""

    size: int = D

    def expanded(self, coordinates: Array) -> Array:
        return np.pad(coordinates, ((0, 0), (0, D - self.size)))

    def projected(self, vectors: Array) -> Array:
        return vectors[:, : self.size]


def limit(*demands):
    return Limit(demands)


def design_point(function: Limit, mode: int, start: Array, basis: Basis | None = None) -> Array:
    found = find_design_point(function, mode, basis or First(), start)
    assert found is not None
    return found


def failure(seed=1):
    """A random vector that is moved beyond the plane."""
    normals = np.random.default_rng(seed).standard_normal(D)
    return normals + (BETA + 1.0 - normals @ ALPHA) * ALPHA


def test_that_of_a_plane_is_found_from_any_failure():
    plane = limit(lambda z: z @ ALPHA / BETA)
    for seed in range(5):
        assert design_point(plane, 0, failure(seed)) == pytest.approx(BETA * ALPHA, abs=0.05)


def test_that_of_a_curved_boundary_lies_on_it_and_along_its_gradient():
    def demand(z):
        return (z @ ALPHA + 0.05 * np.sum((z[:, :10] - 1.0) ** 2, axis=1)) / BETA

    found = design_point(limit(demand), 0, failure())
    gradient = ALPHA + np.r_[0.1 * (found[:10] - 1.0), np.zeros(D - 10)]
    assert demand(found[None])[0] == pytest.approx(1.0, abs=2e-3)
    assert found @ gradient / np.linalg.norm(found) / np.linalg.norm(gradient) > 0.995


def test_each_mode_has_its_own():
    both = limit(lambda z: z[:, 0] / 3.0, lambda z: -z[:, 1] / 4.0)
    start = np.r_[4.0, -5.0, np.random.default_rng(1).standard_normal(D - 2)]
    first, second = (design_point(both, mode, start) for mode in (0, 1))
    assert np.linalg.norm(first) == pytest.approx(3.0, abs=0.02)
    assert np.linalg.norm(second) == pytest.approx(4.0, abs=0.02)
    assert (first[0], second[1]) == pytest.approx((3.0, -4.0), abs=0.02)


def test_there_is_none_where_the_subspace_has_no_failure():
    last = limit(lambda z: z[:, -1] / 3.0)
    assert find_design_point(last, 0, First(D - 1), np.r_[np.ones(D - 1), 5.0]) is None


def test_a_demand_that_jumps_beyond_1_does_not_mislead():
    def demand(z):
        reach = z @ ALPHA / BETA
        return np.where(reach < 1.0, reach, 1.7)

    found = design_point(limit(demand), 0, failure())
    assert np.linalg.norm(found) == pytest.approx(BETA, abs=0.05)


@pytest.mark.parametrize("dimension", [2, 30])
def test_in_the_whole_space_it_is_the_closest_failure(dimension):
    direction = np.linspace(1.0, 2.0, dimension) / np.linalg.norm(np.linspace(1.0, 2.0, dimension))
    rows = []
    plane = Closed(dimension, lambda u: [rows.append(len(u)) or np.sum(u * direction, axis=1) / 4.0])
    start = 4.5 * direction + np.random.default_rng(0).standard_normal(dimension)
    point = find_design_point(plane, 0, WholeSpace(dimension), start, 3)
    assert point is not None
    assert point == pytest.approx(4.0 * direction, abs=0.1)
    assert plane.values(point[None])[0, 0] >= 1.0
    assert sum(rows) <= search_evaluations(dimension, 3)


def test_a_demand_without_slope_is_followed_along_the_ray():
    steps = Closed(2, lambda u: [np.floor(np.linalg.norm(u, axis=1)) / 4.0])
    point = find_design_point(steps, 0, WholeSpace(2), np.array([5.0, 5.0]))
    assert point is not None and 4.0 <= np.linalg.norm(point) < 4.01


def test_no_failure_on_the_ray_is_no_design_point():
    for start in ([-1.0, 0.0], [0.0, 0.0]):
        assert find_design_point(half_space(4.0, 2), 0, WholeSpace(2), np.array(start)) is None


def test_a_start_that_holds_leads_to_the_failure_behind_it():
    point = find_design_point(half_space(4.0, 2), 0, WholeSpace(2), np.array([1.0, 0.5]))
    assert point is not None and np.linalg.norm(point) == pytest.approx(4.0, abs=0.01)


def test_directions_of_one_kind_are_not_split():
    turns = np.linspace(0.0, 0.8, 5)
    directions = np.column_stack([np.cos(turns), np.sin(turns)])
    assert split_off(0, directions) is None
    sectors = split_off(0, np.concatenate([directions, -directions[:2]]))
    assert sectors is not None
    near, far = sectors
    assert len(near.near) == len(far.far) == 5 and len(far.near) == 2


def test_a_direction_between_two_kinds_joins_neither():
    sectors = split_off(0, np.array([[0.0, 1.0], [0.66, 0.75], [1.0, 0.0]]))
    assert sectors is not None
    assert sectors[0].near.tolist() == [[0.0, 1.0]] and sectors[0].far.tolist() == [[1.0, 0.0]]
