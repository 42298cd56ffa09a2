"""Scrambled Sobol sequence: a look at the whole space. For few gains, and to see what a front leaves out.

I. M. Sobol', USSR Computational Mathematics and Mathematical Physics 7(4):86-112, 1967; direction numbers of S. Joe, F. Y. Kuo,
SIAM J. Scientific Computing 30(5):2635-2654, 2008, scrambled by J. Matousek, J. Complexity 14(4):527-556, 1998. The points are
those of `scipy.stats.qmc.Sobol` to the last bit; importing that takes 0.6 s, so only its direction numbers are read.
"""

from importlib.util import find_spec
from pathlib import Path

import numpy as np

from plant.seeds import generator
from tuner.search.uniform import Uniform

BITS = 30
Numbers = np.ndarray


class Sobol:
    """A scrambled sequence in `dimensions` dimensions; rng: source of the scrambling."""

    def __init__(self, dimensions: int, rng: np.random.Generator) -> None:
        # SciPy samples from a child of the generator that it is given.
        (rng,) = rng.spawn(1)
        self._point = rng.integers(2, size=(dimensions, BITS), dtype=np.uint32) @ (
            1 << np.arange(BITS, dtype=np.uint32)
        )
        lower = np.tril(rng.integers(2, size=(dimensions, BITS, BITS), dtype=np.uint32), -1) | np.eye(
            BITS, dtype=np.uint32
        )
        self._directions = scramble(directions(dimensions), lower)
        self._drawn = 0

    def random(self, count: int) -> np.ndarray:
        """Return the next points (count, dimensions) of the unit cube."""
        # From point k - 1 to k, the direction of the lowest zero of k - 1 changes (Gray code).
        numbers = np.arange(self._drawn, self._drawn + count)
        lowest = [((k - 1) ^ k).bit_length() - 1 for k in numbers.tolist() if k]
        changes = self._directions[:, lowest].T
        start = np.zeros_like(self._point) if self._drawn else self._point
        points = np.bitwise_xor.accumulate(changes, axis=0) ^ self._point
        points = points if self._drawn else np.concatenate([start[None], points], axis=0)
        self._drawn += count
        self._point = points[-1] if count else self._point
        return points / 2**BITS


def directions(dimensions: int) -> Numbers:
    """Return the direction numbers (dimensions, BITS), a coordinate's first bit highest."""
    package = find_spec("scipy")
    assert package is not None and package.origin is not None, "a dependency"
    with np.load(Path(package.origin).parent / "stats" / "_sobol_direction_numbers.npz") as file:
        polynomials, first = file["poly"][:dimensions].tolist(), file["vinit"][:dimensions].tolist()
    rows = []
    for polynomial, begin in zip(polynomials, first, strict=True):
        degree = polynomial.bit_length() - 1
        row = [1] * BITS if degree == 0 else begin[:degree]
        for j in range(len(row), BITS):
            new = row[j - degree]
            for k in range(degree):
                if polynomial >> (degree - 1 - k) & 1:
                    new ^= row[j - k - 1] << (k + 1)
            row.append(new)
        rows.append([number << (BITS - 1 - j) for j, number in enumerate(row)])
    return np.array(rows, dtype=np.uint32)


def scramble(numbers: Numbers, lower: Numbers) -> Numbers:
    """Return direction numbers (d, BITS) times lower triangular bit matrices (d, BITS, BITS)."""
    places = np.arange(BITS - 1, -1, -1, dtype=np.uint32)
    bits = numbers[:, :, None] >> places & 1
    return np.einsum("dpk,djk->djp", lower, bits) % 2 @ (1 << places)


class SobolSequence(Uniform):
    """Quasi-random search, independent of results; the sequence begins with the second generation."""

    def __init__(self, first: np.ndarray, n_objectives: int, n_constraints: int, seed: int) -> None:
        super().__init__(first, n_objectives, n_constraints, seed)
        self._sequence = Sobol(first.shape[1], generator(seed, "search/sobol", 0))

    def sample(self, count: int) -> np.ndarray:
        """Return points (count, d) of the next generation."""
        return self._sequence.random(count)
