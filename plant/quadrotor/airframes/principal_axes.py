"""Principal axes of a covariance, the same on every machine.

LAPACK leaves the signs of eigenvectors open and, of equal eigenvalues, the vectors themselves: any basis of their space will do,
and rounding picks one. Two numbers of one deviation without correlation have equal eigenvalues. The projector on such a space is
unique; its axes here are those of its largest columns, taken one after the other (Gram-Schmidt with pivots).
"""

import numpy as np
from numpy.typing import NDArray

from plant.ties import first_largest

Array = NDArray[np.float64]
EQUAL = 1e-9
"""Difference of two eigenvalues, relative to the largest, up to which they are equal."""


def principal_axes(covariance: Array) -> Array:
    """Return the principal axes (n, n) of a covariance as columns.

    Each is as long as its standard deviation, the longest first.
    """
    values, vectors = np.linalg.eigh(covariance)
    values, vectors = values[::-1], vectors[:, ::-1]
    ends = np.flatnonzero(values[:-1] - values[1:] > EQUAL * abs(values[0])) + 1
    spaces = np.split(np.arange(len(values)), ends)
    bases = [_basis(vectors[:, space]) for space in spaces]
    # Equal eigenvalues have their mean, for rounding splits them.
    means = np.concatenate([np.full(len(space), values[space].mean()) for space in spaces])
    return np.concatenate(bases, axis=1) * np.sqrt(np.maximum(means, 0.0))


def _basis(vectors: Array) -> Array:
    """Return an orthonormal basis (n, m) that depends on the space of vectors (n, m) alone."""
    projector, basis = vectors @ vectors.T, []
    for _ in range(vectors.shape[1]):
        column = projector[:, first_largest(np.diag(projector), scale=1.0)]
        axis = column / np.linalg.norm(column)
        basis.append(axis)
        projector = projector - np.outer(axis, axis)
    return np.stack(basis, axis=1)
