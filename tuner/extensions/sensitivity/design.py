"""The points of a variance-based sensitivity analysis.

Two matrices A and B of n points each, and for every variable i the matrix AB_i, which is A with column i of B: n (d + 2)
points in all. A. Saltelli, P. Annoni, I. Azzini, F. Campolongo, M. Ratto, S. Tarantola, "Variance based sensitivity analysis
of model output", Computer Physics Communications 181(2):259-270, 2010, sections 3 and 5: A and B are the halves of one
scrambled Sobol sequence in 2 d dimensions.
"""

from dataclasses import dataclass

import numpy as np

from plant.errors import InputError

Array = np.ndarray
# Below 8 base samples a bootstrap has nothing to draw from; 2^16 with 7 variables and 32 scenarios are 19 million flights.
MIN_SAMPLES, MAX_SAMPLES = 8, 65_536


@dataclass(frozen=True)
class SobolDesign:
    """points (n (d + 2), d) of the unit cube: A, B, AB_1, ..., AB_d one below the other; base: n."""

    points: Array
    base: int

    @property
    def dimensions(self) -> int:
        """Number of variables d."""
        return self.points.shape[1]

    @property
    def independent(self) -> int:
        """Number of independent points: the leading ones, of A and B."""
        return 2 * self.base

    def split(self, values: Array) -> tuple[Array, Array, Array]:
        """Return values (n (d + 2), q) split: into f_A (q, n), f_B (q, n) and f_AB (d, q, n)."""
        blocks = np.moveaxis(values.reshape(self.dimensions + 2, self.base, -1), -1, 1)
        return blocks[0], blocks[1], blocks[2:]


def checked_base(base: int) -> int:
    """Return the number of base samples; InputError unless it is a power of two, which the Sobol sequence is balanced for."""
    if base & (base - 1) or not MIN_SAMPLES <= base <= MAX_SAMPLES:
        near = min((2**k for k in range(3, 17)), key=lambda power: abs(power - base))
        raise InputError(
            f"given {base}; allowed: a power of two from {MIN_SAMPLES} to {MAX_SAMPLES}, for instance {near}",
            key="--samples",
        )
    return base


def sobol_design(base: int, dimensions: int, draw: np.random.Generator) -> SobolDesign:
    """Return the design of `base` samples: a power of two."""
    from scipy.stats import qmc

    # "seed", because SciPy before 1.15 knows no "rng".
    halves = qmc.Sobol(d=2 * dimensions, seed=draw).random(base)  # pyright: ignore[reportCallIssue]
    a, b = halves[:, :dimensions], halves[:, dimensions:]
    pages = []
    for i in range(dimensions):
        page = a.copy()
        page[:, i] = b[:, i]
        pages.append(page)
    return SobolDesign(np.concatenate([a, b, *pages], axis=0), base)
