"""Design point: the failure nearest to the origin, which is the most likely one.

The space is that of standard normals. A direction fails at the distance where its demand over capacity reaches 1. From the
direction of a known failure the search turns to the gradient of the demand at the boundary, as HL-RF does, and takes of
several turns the one whose distance is smallest, so the distance never grows. It finds the nearest failure of a neighborhood,
not that of all (Breitung).

- R. Rackwitz, B. Fiessler, "Structural reliability under combined random load sequences", Computers and Structures
  9(5):489-494, 1978: the gradient at the boundary is the next direction.
- A. Der Kiureghian, T. Dakessian, "Multiple design points in first and second-order reliability", Structural Safety
  20(1):37-49, 1998: one for each mode.

Processes in time have thousands of normals, which the search takes in bins of time: as many numbers as a gradient can have. The
part of a process that is faster than a bin stays 0.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.tails.estimation.limit_function import Array, LimitFunction
from tuner.extensions.tails.estimation.splitting import evaluate

ROWS = 128
"""Vectors that are evaluated at once; one of 40,000 numbers takes 0.3 MB."""
DIFFERENCE_STEP = 0.02
"""Step of the differences of a gradient, in standard deviations."""
SETBACK = 0.1
"""Distance before the boundary at which a gradient is taken, in standard deviations."""
TURNS = (1.0, 0.6, 0.3, 0.1, 0.03)
"""Shares of the way to the direction of the gradient."""
REACH = (0.0, *np.geomspace(0.5, 64.0, 15).tolist())
"""Distances at which the direction of a failure is tried, over its own."""
HALVINGS = 10
"""Number of halvings of the interval that holds the distance of a direction."""
MIN_GAIN = 0.005
"""Share by which a step must come nearer for the search to go on."""
MAX_STEPS = 12
"""Steps of a search at most."""


class Basis(Protocol):
    """Orthonormal vectors of a subspace. size: how many there are."""

    @property
    def size(self) -> int: ...  # noqa: D102

    def expanded(self, coordinates: Array) -> Array:
        """Return vectors (n, d) of coordinates (n, size)."""
        ...

    def projected(self, vectors: Array) -> Array:
        """Return coordinates (n, size) of vectors (n, d)."""
        ...


@dataclass(frozen=True)
class WholeSpace:
    """The axes themselves, of a space of few dimensions."""

    size: int

    def expanded(self, coordinates: Array) -> Array:
        """Return the coordinates."""
        return coordinates

    def projected(self, vectors: Array) -> Array:
        """Return the vectors."""
        return vectors


class Boundary(NamedTuple):
    """A failure: its direction (size,), a unit vector, and its distance."""

    direction: Array
    distance: float


def find_design_point(
    limit: LimitFunction, mode: int, basis: Basis, failure: Array, steps: int = MAX_STEPS
) -> Array | None:
    """Return the most likely failure (d,) of a mode near a known one.

    None where no multiple of that fails in the subspace.

    Args:
        limit: limit function.
        mode: column of its values.
        basis: basis of the subspace.
        failure: vector (d,) that fails, or would farther out.
        steps: at most.
    """
    demand = _Demand(limit, mode, basis)
    best = _first(demand, basis.projected(failure[None])[0])
    for _ in range(steps if best is not None else 0):
        assert best is not None
        gradient = demand.gradient((best.distance - SETBACK) * best.direction)
        size = float(np.linalg.norm(gradient))
        if size == 0.0:
            break
        turned = [(1.0 - share) * best.direction + share * gradient / size for share in TURNS]
        nearest = _nearest(demand, np.array([each / np.linalg.norm(each) for each in turned]), best.distance)
        if nearest is None:
            break
        gain, best = 1.0 - nearest.distance / best.distance, nearest
        if gain < MIN_GAIN:
            break
    return None if best is None else basis.expanded(best.distance * best.direction[None])[0]


def search_evaluations(size: int, steps: int) -> int:
    """Return the most rows that a search in a subspace takes."""
    return len(REACH) + HALVINGS + steps * (1 + size + len(TURNS) * (1 + HALVINGS))


class _Demand:
    """Demand of a mode in the coordinates of a subspace."""

    def __init__(self, limit: LimitFunction, mode: int, basis: Basis) -> None:
        self._limit, self._mode, self._basis = limit, mode, basis

    def values(self, coordinates: Array) -> Array:
        """Return the demand (n,) of coordinates (n, size)."""
        parts = [coordinates[first : first + ROWS] for first in range(0, len(coordinates), ROWS)]
        return np.concatenate([evaluate(self._limit, self._basis.expanded(part))[:, self._mode] for part in parts])

    def fails(self, coordinates: Array) -> NDArray[np.bool_]:
        """Return True (n,) where the demand of coordinates (n, size) reaches 1."""
        return self.values(coordinates) >= 1.0

    def gradient(self, at: Array) -> Array:
        """Return the gradient (size,) by forward differences.

        A failure within a step counts as one that is just reached.
        """
        values = np.minimum(self.values(np.vstack([at, at + DIFFERENCE_STEP * np.eye(len(at))])), 1.0)
        return (values[1:] - values[0]) / DIFFERENCE_STEP


def _first(demand: _Demand, start: Array) -> Boundary | None:
    """Return the boundary in the direction of a vector (size,).

    None where none of its multiples fails.
    """
    length = float(np.linalg.norm(start))
    if length == 0.0:
        return None
    distances = length * np.array(REACH)
    fails = demand.fails(distances[:, None] * (start / length))
    place = int(np.argmax(fails))
    if not fails[place]:
        return None
    return _narrowed(demand, start[None] / length, distances[max(place - 1, 0)], distances[place])


def _nearest(demand: _Demand, directions: Array, distance: float) -> Boundary | None:
    """Return the direction (n, size) that fails nearest.

    None where none fails at a distance.
    """
    fails = demand.fails(distance * directions)
    return _narrowed(demand, directions[fails], 0.0, distance) if np.any(fails) else None


def _narrowed(demand: _Demand, directions: Array, low: float, high: float) -> Boundary:
    """Return the direction (n, size) that fails nearest.

    All fail at `high`; those that do not where another does are left out.
    """
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        fails = demand.fails(middle * directions)
        if np.any(fails):
            directions, high = directions[fails], middle
        else:
            low = middle
    return Boundary(directions[0], high)
