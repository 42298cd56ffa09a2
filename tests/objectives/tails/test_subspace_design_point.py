"""Design points beside those that are known in closed form."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from objectives.tails.subspace_design_point import Basis, find_design_point

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
