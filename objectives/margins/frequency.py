"""Frequency response of closed loops in modal form: T(z) = sum of r_k/(z - p_k), for many loops at once.

Poles first: they say whether a loop is stable at all. The residues come from the eigenvectors. Where these are dependent, as for
a chain of delays with all poles at 0, the entries of the matrix are moved by 1e-13 of their size: that moves the response as
little, but parts the eigenvectors enough.
"""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plant.seeds import generator

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]

LOWEST, POINTS = 1e-2, 400
# A pole at this distance from the unit circle or beyond counts as not stable.
ON_CIRCLE = 1e-10
# An inverse of eigenvectors of length 1 larger than this has no digits left; a matrix is then moved by this share of its
# entries. Up to there T was right to 4e-9 on six thousand loops of all laws.
DEPENDENT, MOVED = 1e12, 1e-13


def frequency_grid(h: float, points: int = POINTS) -> Array:
    """Points of the unit circle (3, 1 + points): w [rad/s], cos wh, sin wh, at 0 and log-spaced from 0.01 to pi/h."""
    w = np.concatenate([[0.0], np.geomspace(LOWEST, np.pi / h, points)])
    return np.stack([w, np.cos(w * h), np.sin(w * h)])


@dataclass(frozen=True)
class Modes:
    """Closed loops as modes.

    poles (n, b); right (n, b, b): eigenvectors in columns; left (n, b, b): their inverse; size (n,): largest |pole|.
    """

    poles: Complex
    right: Complex
    left: Complex
    size: Array

    @property
    def stable(self) -> Mask:
        """Return the mask (n,) of loops with all poles inside the unit circle."""
        return self.size < 1.0 - ON_CIRCLE

    @property
    def growth(self) -> Array:
        """Logarithm of the largest |pole|, (n,): what the slowest mode grows by in a period."""
        return np.log(np.maximum(self.size, 1e-300))

    def residues(self, b: Array, c: Array) -> Complex:
        """Residues (n, k, b) of k loops, the j-th from column j of b (n, b, k) to row j of c (n, k, b)."""
        return (c @ self.right) * np.swapaxes(self.left @ b, -1, -2)

    def response(self, z: Complex, b: Array, c: Array) -> Complex:
        """Responses (n, f, o, u) from inputs of b (n, b, u) to outputs of c (n, o, b) at points z (n, f), without feedthrough."""
        inverse = 1.0 / (z[..., None] - self.poles[:, None, :])
        return (c @ self.right)[:, None] @ (inverse[..., None] * (self.left @ b)[:, None])


def modes_of(a: Array) -> Modes:
    """Modes of state matrices (n, b, b)."""
    poles, right = _eigen(a)
    size = np.max(np.abs(poles), axis=-1)
    left, poor = _inverse(right)
    if poor.any():
        poles[poor], right[poor] = _eigen(_moved(a[poor]))
        left[poor], _ = _inverse(right[poor])
    return Modes(poles, right, left, size)


def _inverse(right: Complex) -> tuple[Complex, Mask]:
    """Inverse of matrices of eigenvectors, and whether it cannot be trusted."""
    with np.errstate(all="ignore"):
        try:
            left = np.linalg.inv(right)
        except np.linalg.LinAlgError:
            # One of them has none: one by one, so that the others keep theirs to the last bit.
            left = np.full_like(right, np.inf)
            for i, one in enumerate(right):
                with suppress(np.linalg.LinAlgError):
                    left[i] = np.linalg.inv(one)
        return left.astype(complex), np.logical_not(np.linalg.norm(left, axis=(-2, -1)) < DEPENDENT)


def _eigen(a: Array) -> tuple[Complex, Complex]:
    poles, right = np.linalg.eig(a)
    return poles.astype(complex), right.astype(complex)


def _moved(a: Array) -> Array:
    shift = MOVED * generator(0, "margins/moved", 0).standard_normal(a.shape[-2:])
    return a * (1.0 + shift) + shift * np.eye(a.shape[-1])


def without_idle(a: Array, b: Array) -> Array:
    """The matrices (n, b, b) with the pole of a state that nothing moves, like an integral of gain zero, put from 1 to 0.

    It stays what it was at the start, nothing, and must not count as a pole on the circle. b (n, b, u): all that can move it.
    """
    own = np.diagonal(a, axis1=-2, axis2=-1)
    moved = np.sum(np.abs(a), axis=-1) - np.abs(own) + np.sum(np.abs(b), axis=-1)
    idle = (moved < 1e-12) & (np.abs(own - 1.0) < 1e-12)
    if not idle.any():
        return a
    return a - idle[..., None] * np.eye(a.shape[-1])
