"""Sampled plants in coordinates of independent outputs, and their poles."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import expm

from plant.model.slope import LinearEquations

Array = np.ndarray
# Share by which each pole is faster than the one before, because equal ones need as many inputs or measurements.
POLE_SPACING = 0.1


def sampled_outputs(
    equations: LinearEquations, outputs: Sequence[int], inputs: Sequence[int], h: float
) -> tuple[Array, Array] | None:
    """Return A (n, n) and B (n, m) of one control period.

    They are between outputs, commands are held; None for outputs that are not independent.

    Args:
        equations: The plant at rest.
        outputs: Rows of n outputs, as many as states.
        inputs: Columns of m inputs.
        h: Control period [s].
    """
    shown, n, m = equations.c[list(outputs)], len(equations.a), len(inputs)
    if len(shown) != n or np.linalg.matrix_rank(shown) < n:
        return None
    generator = np.block([[equations.a, equations.b[:, list(inputs)]], [np.zeros((m, n + m))]])
    moved = expm(h * generator)
    return shown @ moved[:n, :n] @ np.linalg.inv(shown), shown @ moved[:n, n:]


def spaced_poles(time: float, h: float, count: int) -> Array:
    """Return poles at -(1 + 0.1 i)/time of a loop sampled every h [s]."""
    return np.exp(-h / time * (1.0 + POLE_SPACING * np.arange(count)))
