"""Subspace of the normals that are constant over bins of time."""

from math import prod

import numpy as np

from plant.normals import NormalSpace

BINS = 80
"""Bins of a flight: of one of 8 s, what air and sensors do below 5 Hz."""


class TimeBins:
    """Orthonormal vectors, one for each bin of each process.

    Each number that is no process has one too.

    A process is an array with more rows than bins. Its first row is a bin of its own, for it draws where the process starts
    (`plant.air.linear_process`): of slow air, most of what comes.

    Args:
        space: Of the normals.
        count: Of bins of a process.
    """

    def __init__(self, space: NormalSpace, count: int = BINS) -> None:
        groups, size = np.empty(space.dimension, dtype=np.intp), 0
        for place, shape in space.arrays:
            rows, columns = (shape[0], prod(shape[1:])) if shape else (1, 1)
            bins = np.arange(rows)
            if rows > count:
                bins[1:] = 1 + np.arange(rows - 1) * count // (rows - 1)
            numbers = bins[:, None] * columns + np.arange(columns)
            groups[place : place + rows * columns] = size + numbers.ravel()
            size += int(bins[-1] + 1) * columns
        self.size = size
        self._groups = groups
        self._scale = 1.0 / np.sqrt(np.bincount(groups, minlength=size))

    def expanded(self, coordinates: np.ndarray) -> np.ndarray:
        """Return vectors (n, d) of coordinates (n, size)."""
        return (coordinates * self._scale)[:, self._groups]

    def projected(self, vectors: np.ndarray) -> np.ndarray:
        """Return coordinates (n, size) of vectors (n, d)."""
        sums = [np.bincount(self._groups, weights=vector, minlength=self.size) for vector in vectors]
        return np.array(sums) * self._scale
