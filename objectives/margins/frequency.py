"""Frequency response of closed loops in modal form: T(z) = sum of r_k/(z - p_k), for many loops at once.

Poles first: they say whether a loop is stable at all. The residues come from the eigenvectors. If these are dependent, as for
a chain of delays with all poles at 0, the entries of the matrix are moved by 1e-13 of the largest: that moves the response as
little, but parts the eigenvectors enough.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from objectives.margins.schur import split
from plant.backends.compiling import read_only
from plant.seeds import generator
from plant.threads import parallel_map, shares

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]

LOWEST, POINTS = 1e-2, 400
# Loops that are worth a thread: 0.5 ms to split or to read.
SHARE = 16
# A pole at this distance from the unit circle or beyond counts as not stable.
ON_CIRCLE = 1e-10
STABLE = 1.0 - ON_CIRCLE
# An inverse of eigenvectors of length 1 larger than this has no digits left; the entries of a matrix are then moved by this share
# of the largest. Up to there T was right to 4e-9 on six thousand loops of all laws.
DEPENDENT, MOVED = 1e12, 1e-13


def frequency_grid(h: float, points: int = POINTS, lowest: float = LOWEST) -> Array:
    """Points of the unit circle (3, 1 + points): w [rad/s], cos wh, sin wh, at 0 and log-spaced from the lowest to pi/h."""
    w = np.concatenate([[0.0], np.geomspace(lowest, np.pi / h, points)])
    return np.stack([w, np.cos(w * h), np.sin(w * h)])


@dataclass(frozen=True)
class Modes:
    """Closed loops as modes.

    poles (n, b); shown (n, o, b): what each mode gives to each output, a row of C times a right eigenvector; driven (n, b, u):
    what each input gives to each mode; size (n,): largest |pole|.
    """

    poles: Complex
    shown: Complex
    driven: Complex
    size: Array

    @property
    def stable(self) -> Mask:
        """Return the mask (n,) of loops with all poles inside the unit circle."""
        return self.size < STABLE

    @property
    def growth(self) -> Array:
        """Logarithm of the largest |pole|, (n,): what the slowest mode grows by in a period."""
        return np.log(np.maximum(self.size, 1e-300))

    def residues(self, outputs: slice, inputs: slice) -> Complex:
        """Return the residues (n, k, b) of k loops.

        The j-th is from the j-th of some inputs to the j-th of as many outputs.
        """
        return self.shown[:, outputs] * np.swapaxes(self.driven[:, :, inputs], -1, -2)

    def response(self, z: Complex, outputs: Sequence[int], inputs: Sequence[int]) -> Complex:
        """Return responses (n, f, o, u) from inputs to outputs at z (n, f), without feedthrough."""
        inverse = 1.0 / (z[..., None] - self.poles[:, None, :])
        return self.shown[:, None, outputs] @ (inverse[..., None] * self.driven[:, None, :, inputs])

    def of(self, rows: Mask) -> "Modes":
        """Return some of them."""
        return Modes(self.poles[rows], self.shown[rows], self.driven[rows], self.size[rows])


def modes_of(a: Array, b: Array, c: Array, *, radius: float = np.inf) -> Modes:
    """Modes of state matrices a (n, b, b) with inputs b (n, b, u) and outputs c (n, o, b).

    radius: of matrices with a pole that is not inside this circle only the poles are found; shown and driven are 0.
    """
    poles, driven, shown, spread = _split(a, b, c, radius)
    size = np.max(np.abs(poles), axis=-1)
    poor = ~(spread < DEPENDENT)
    if poor.any():
        poles[poor], driven[poor], shown[poor], spread_moved = _split(moved(a[poor]), b[poor], c[poor], radius)
        # A matrix that could not be split, as a chain of 40 delays, has no poles yet: without any it counts as not stable.
        sizes = np.where(np.isnan(spread_moved), np.inf, np.max(np.abs(poles[poor]), axis=-1))
        size[poor] = np.where(np.isnan(spread[poor]), sizes, size[poor])
    return Modes(poles, shown, driven, size)


def _split(a: Array, b: Array, c: Array, radius: float) -> tuple[Complex, Complex, Complex, Array]:
    """The findings of `schur.split`."""
    (n, states), inputs, outputs = a.shape[:2], b.shape[-1], c.shape[-2]
    poles, spread = np.empty((n, states), complex), np.empty(n)
    driven, shown = np.zeros((n, states, inputs), complex), np.zeros((n, outputs, states), complex)
    a, b, c = (read_only(part) for part in (a, b, c))
    parallel_map(
        lambda rows: split(a[rows], b[rows], c[rows], radius, poles[rows], driven[rows], shown[rows], spread[rows]),
        shares(n, SHARE),
    )
    return poles, driven, shown, spread


def moved(a: Array) -> Array:
    """Return matrices (n, b, b) perturbed to part dependent eigenvectors.

    Entries move by a share of the largest.
    """
    shift = MOVED * generator(0, "margins/moved", 0).standard_normal(a.shape[-2:])
    return a + shift * np.max(np.abs(a), axis=(-2, -1), keepdims=True)


def without_idle(a: Array, b: Array) -> Array:
    """Return matrices (n, b, b) with the poles of idle states at 0.

    Nothing moves such a state, like an integral of gain zero, and its pole is 1 in a.
    It stays what it was at the start, nothing, and must not count as a pole on the circle. b (n, b, u): all that can move it.
    """
    diagonal = np.diagonal(a, axis1=-2, axis2=-1)
    moved = np.sum(np.abs(a), axis=-1) - np.abs(diagonal) + np.sum(np.abs(b), axis=-1)
    idle = (moved < 1e-12) & (np.abs(diagonal - 1.0) < 1e-12)
    if not idle.any():
        return a
    return a - idle[..., None] * np.eye(a.shape[-1])
