"""Limit functions of few normals whose probabilities are known in closed form."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Closed:
    dimension: int
    columns: Callable[[np.ndarray], list[np.ndarray]]
    modes: tuple[str, ...] = ("only",)

    def values(self, normals: np.ndarray) -> np.ndarray:
        return np.column_stack(self.columns(normals))


def half_space(distance: float, dimension: int = 5) -> Closed:
    """Fails where the first normal reaches a distance."""
    return Closed(dimension, lambda u: [u[:, 0] / distance])


def corner(first: float, second: float) -> Closed:
    """Fails by either of two independent modes."""
    return Closed(4, lambda u: [u[:, 0] / first, u[:, 1] / second], ("first", "second"))
