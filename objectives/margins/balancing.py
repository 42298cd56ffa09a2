"""Diagonal scaling of a matrix by powers of two.

R. James, J. Langou, B. R. Lowery, "On matrix balancing and eigenvector computation", arXiv:1401.5766, 2014, as LAPACK's dgebal
does it. SciPy has that too, but `scipy.linalg` takes 0.13 s to import.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RADIX = 2.0
# A row and its column are scaled where that lessens the sum of their norms to this share.
LESSENED = 0.95


def balancing_scale(matrix: Array) -> Array:
    """Return the scale s (n,) that balances a matrix (n, n) as diag(s)^-1 matrix diag(s)."""
    balanced, scale = matrix.astype(float), np.ones(len(matrix))
    is_settled = False
    while not is_settled:
        is_settled = True
        for i in range(len(scale)):
            column, row = balanced[:, i], balanced[i]
            factor = _factor(sqrt(float(column @ column)), sqrt(float(row @ row)))
            if factor != 1.0:
                scale[i] *= factor
                balanced[i] /= factor
                balanced[:, i] *= factor
                is_settled = False
    return scale


def _factor(column: float, row: float) -> float:
    """Return the factor of a column, the inverse of its row's."""
    if column == 0.0 or row == 0.0:
        return 1.0
    factor, before = 1.0, column + row
    while column < row / RADIX:
        factor, column, row = factor * RADIX, column * RADIX, row / RADIX
    while column / RADIX >= row:
        factor, column, row = factor / RADIX, column / RADIX, row * RADIX
    return factor if column + row < LESSENED * before else 1.0
