"""Subspace of the normals that are constant over bins of time."""

from math import prod

import numpy as np

from tuner.extensions.tails.normals import NormalSpace

BINS = 80
"""Bins of a flight: of one of 8 s, what air and sensors do below 5 Hz."""


class TimeBins:
    """Orthonormal vectors, one for each bin of each process.

    Each number that is no process has one too.

    A process is an array with more rows than bins. Its first row is a bin of its own, for it draws where the process starts
    (`plant.air.linear_process`): of slow air, most of what comes.

    Args:
        space: Space of the normals.
        count: Number of bins of a process.
        part: Alone, all else stays at 0; None for all parts.
    """

    def __init__(self, space: NormalSpace, count: int = BINS, part: str | None = None) -> None:
        groups, size = np.full(space.dimension, -1, dtype=np.intp), 0
        inside = slice(0, space.dimension) if part is None else space.parts[part]
        for place, shape in space.arrays:
            if not inside.start <= place < inside.stop:
                continue
            rows, columns = (shape[0], prod(shape[1:])) if shape else (1, 1)
            bins = np.arange(rows)
            if rows > count:
                bins[1:] = 1 + np.arange(rows - 1) * count // (rows - 1)
            numbers = bins[:, None] * columns + np.arange(columns)
            groups[place : place + rows * columns] = size + numbers.ravel()
            size += int(bins[-1] + 1) * columns
        self.size = size
        self._inside = np.flatnonzero(groups >= 0)
        self._groups = groups[self._inside]
        self._scale = 1.0 / np.sqrt(np.bincount(self._groups, minlength=size))
        self._dimension = space.dimension

    def expanded(self, coordinates: np.ndarray) -> np.ndarray:
        """Return vectors (n, d) of coordinates (n, size)."""
        vectors = np.zeros((len(coordinates), self._dimension))
        vectors[:, self._inside] = (coordinates * self._scale)[:, self._groups]
        return vectors

    def projected(self, vectors: np.ndarray) -> np.ndarray:
        """Return coordinates (n, size) of vectors (n, d)."""
        sums = [np.bincount(self._groups, weights=vector[self._inside], minlength=self.size) for vector in vectors]
        return np.array(sums) * self._scale
