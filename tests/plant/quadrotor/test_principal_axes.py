"""Principal axes do not depend on which eigenvectors a library returns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant.quadrotor.airframes.principal_axes import principal_axes

COVARIANCES = {
    "equal": np.eye(4) * 0.04,
    "two equal": np.diag([0.09, 0.04, 0.04, 0.01]),
    "equal and correlated": np.array([[0.04, 0.02, 0.0], [0.02, 0.04, 0.0], [0.0, 0.0, 0.02]]),
    "singular": np.outer([0.1, 0.1, 0.2], [0.1, 0.1, 0.2]),
    "of equal parts": np.array([[2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0]]),
}


@pytest.mark.parametrize("name", COVARIANCES)
def test_axes_are_orthogonal_and_add_up_to_the_covariance(name: str) -> None:
    axes = principal_axes(COVARIANCES[name])
    np.testing.assert_allclose(axes @ axes.T, COVARIANCES[name], atol=1e-15)
    lengths = np.linalg.norm(axes, axis=0)
    np.testing.assert_allclose(axes.T @ axes, np.diag(lengths**2), atol=1e-15)
    assert np.all(np.diff(lengths) <= 1e-15)


@given(st.sampled_from(sorted(COVARIANCES)), st.integers(0, 2**32 - 1))
def test_another_basis_of_a_space_leaves_the_axes_as_they_are(name: str, seed: int) -> None:
    """A library that rounds otherwise: the covariance moves by 1e-16, upon which eigenvectors of equal values turn at will."""
    noise = 1e-16 * np.random.default_rng(seed).standard_normal(COVARIANCES[name].shape)
    moved = COVARIANCES[name] + noise + noise.T
    np.testing.assert_allclose(principal_axes(moved), principal_axes(COVARIANCES[name]), atol=2e-8)
