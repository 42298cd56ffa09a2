"""The scaling of a matrix against LAPACK's."""

import numpy as np
import pytest
from scipy.linalg import matrix_balance

from objectives.margins.balancing import balancing_scale


@pytest.mark.parametrize("size", [1, 2, 7, 40])
def test_the_scale_is_that_of_lapack(size):
    rng = np.random.default_rng(size)
    for _ in range(20):
        spread = 10.0 ** rng.uniform(-6.0, 6.0, size)
        matrix = rng.standard_normal((size, size)) * spread / spread[:, None] * (rng.random((size, size)) < 0.6)
        _, (scale, _) = matrix_balance(matrix, permute=False, separate=True)
        np.testing.assert_array_equal(balancing_scale(matrix), scale)


def test_rows_and_columns_of_nothing_keep_their_scale():
    matrix = np.array([[1.0, 0.0, 1e6], [0.0, 0.0, 0.0], [1e-6, 0.0, 2.0]])
    scale = balancing_scale(matrix)
    assert scale[1] == 1.0 and 0.5 < scale[2] / scale[0] * 1e6 < 2.0
