"""Design point: the failure nearest to the origin, which is the most likely one.

The space is that of standard normals. A direction fails at the distance where its demand over capacity reaches 1 first. From
the direction of a known failure the search turns to the gradient of the demand at the boundary, as HL-RF does, and takes of
several turns the one whose distance is smallest, so the distance never grows. It finds the nearest failure of a neighborhood,
not that of all (Breitung).

- R. Rackwitz, B. Fiessler, "Structural reliability under combined random load sequences", Computers and Structures
  9(5):489-494, 1978: the gradient at the boundary is the next direction.
- A. Der Kiureghian, T. Dakessian, "Multiple design points in first and second-order reliability", Structural Safety
  20(1):37-49, 1998: one for each mode.

Processes in time have thousands of normals, which the search takes in bins of time: as many numbers as a gradient can have. What
of a process is faster than a bin it leaves at 0.
"""

from typing import NamedTuple, Protocol

import numpy as np

from objectives.tails.limit_function import Array, LimitFunction

ROWS = 128
"""Vectors that are evaluated at once; one of 40,000 numbers takes 0.3 MB."""
DIFFERENCE, BACK = 0.02, 0.1
"""Step of the differences of a gradient, and how far before the boundary it is taken, in standard deviations."""
TURNS = (1.0, 0.6, 0.3, 0.1, 0.03)
"""Shares of the way to the direction of the gradient."""
DISTANCES, ROUNDS = 12, 4
"""Distances along a direction that are evaluated at once, and how often their interval is narrowed."""
REACH = 1.5
"""Distances beyond the best one so far at which a direction may fail."""
GAIN, MOST_STEPS = 0.005, 12
"""Share by which a step must come nearer for the search to go on, and steps at most."""


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


class Boundary(NamedTuple):
    """A failure: its direction (size,), a unit vector, and its distance."""

    direction: Array
    distance: float


def find_design_point(limit: LimitFunction, mode: int, basis: Basis, failure: Array) -> Array | None:
    """Return the most likely failure (d,) of a mode near a known one.

    None where no multiple of that fails in the subspace.
    """
    demand = _Demand(limit, mode, basis)
    start = basis.projected(failure[None])[0]
    length = float(np.linalg.norm(start))
    if length == 0.0:
        return None
    best = _nearest(demand, start[None] / length, length)
    for _ in range(MOST_STEPS if best is not None else 0):
        assert best is not None
        gradient = demand.gradient((best.distance - BACK) * best.direction)
        size = float(np.linalg.norm(gradient))
        if size == 0.0:
            break
        turned = [(1.0 - share) * best.direction + share * gradient / size for share in TURNS]
        nearest = _nearest(demand, np.array([each / np.linalg.norm(each) for each in turned]), best.distance)
        if nearest is None or nearest.distance > (1.0 - GAIN) * best.distance:
            best = nearest if nearest is not None and nearest.distance < best.distance else best
            break
        best = nearest
    return None if best is None else basis.expanded(best.distance * best.direction[None])[0]


class _Demand:
    """Demand of a mode in the coordinates of a subspace."""

    def __init__(self, limit: LimitFunction, mode: int, basis: Basis) -> None:
        self._limit, self._mode, self._basis = limit, mode, basis

    def values(self, coordinates: Array) -> Array:
        """Return the demand (n,) of coordinates (n, size).

        It is infinite where there is no value.
        """
        parts = [coordinates[first : first + ROWS] for first in range(0, len(coordinates), ROWS)]
        demands = [self._limit.values(self._basis.expanded(part))[:, self._mode] for part in parts]
        return np.nan_to_num(np.concatenate(demands), nan=np.inf)

    def gradient(self, at: Array) -> Array:
        """Return the gradient (size,) by forward differences.

        A failure within a step counts as one that is just reached.
        """
        values = np.minimum(self.values(np.vstack([at, at + DIFFERENCE * np.eye(len(at))])), 1.0)
        return (values[1:] - values[0]) / DIFFERENCE


def _nearest(demand: _Demand, directions: Array, reach: float) -> Boundary | None:
    """Return the direction that fails at the smallest distance.

    None where none fails within REACH times `reach`.
    """
    low, high = np.zeros(len(directions)), np.full(len(directions), REACH * reach)
    fails = np.zeros(len(directions), dtype=bool)
    for _ in range(ROUNDS):
        distances = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, DISTANCES + 1)[1:]
        points = distances[:, :, None] * directions[:, None, :]
        reached = demand.values(points.reshape(-1, points.shape[-1])).reshape(distances.shape) >= 1.0
        fails |= reached.any(axis=1)
        first = np.argmax(reached, axis=1)
        for i in np.flatnonzero(reached.any(axis=1)).tolist():
            high[i] = distances[i, first[i]]
            low[i] = distances[i, first[i] - 1] if first[i] else low[i]
    if not fails.any():
        return None
    best = int(np.argmin(np.where(fails, high, np.inf)))
    return Boundary(directions[best], float(high[best]))
