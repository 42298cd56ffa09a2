"""The nonlinear terms of linearised loops closed, each as a gain, compiled: w = g s for every candidate and amplitude.

With s = C_s x + D_s u + D_sw w, the terms give w = (1 - g D_sw)^{-1} g (C_s x + D_s u), which is what all other rows then have
of w. In NumPy the products of so many small matrices, and the memory between them, take three times as long.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from objectives.margins.linearise import LinearLoops
from plant.backends.cache import keep_file

Array = NDArray[np.float64]

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract", "nsz"}}
INLINED = {**OPTIONS, "forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into those that call it."""
    return numba.njit(**INLINED)(function)


def close_terms(loops: LinearLoops, gain: Array) -> LinearLoops:
    """Close the nonlinear terms as w = gain s, gains (..., terms); the result keeps w as an input that is added to them.

    Leading axes of the loops and of the gains broadcast. A term that its own output feeds with a loop gain of 1 leaves infinite
    entries.
    """
    if not loops.n_terms:
        return loops
    leading = np.broadcast_shapes(loops.a.shape[:-2], gain.shape[:-1])
    rows = (*(1,) * (2 - len(leading)), *leading)
    given = [np.broadcast_to(part, (*rows, *part.shape[-2:])) for part in (loops.a, loops.b, loops.c, loops.d)]
    found = [np.empty(part.shape) for part in given]
    close_all(tuple(given), np.broadcast_to(gain, (*rows, loops.n_terms)), loops.terms.start, tuple(found))
    a, b, c, d = (part.reshape(*leading, *part.shape[2:]) for part in found)
    return replace(loops, a=a, b=b, c=c, d=d)


@inlined
def solve(matrix: Array, right: Array) -> None:
    """Overwrite right (t, m) with the solution X (t, m) of matrix X = right; matrix (t, t) is used up. Gauss and Jordan."""
    size = len(matrix)
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(size):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            for j in range(right.shape[1]):
                right[k, j], right[pivot, j] = right[pivot, j], right[k, j]
        by = 1.0 / matrix[k, k]
        for j in range(right.shape[1]):
            right[k, j] *= by
        for j in range(k + 1, size):
            matrix[k, j] *= by
        for i in range(size):
            if i != k:
                factor = matrix[i, k]
                for j in range(k + 1, size):
                    matrix[i, j] -= factor * matrix[k, j]
                for j in range(right.shape[1]):
                    right[i, j] -= factor * right[k, j]


@inlined
def add_product(given: Array, of_terms: Array, answers: Array, start: int, found: Array) -> None:
    """Fill found (m, p) with given (m, p) plus of_terms (m, t) times the columns of answers (t, ...) from `start` on."""
    for i in range(given.shape[0]):
        for j in range(given.shape[1]):
            total = given[i, j]
            for k in range(of_terms.shape[1]):
                total += of_terms[i, k] * answers[k, start + j]
            found[i, j] = total


def close_all(given: tuple[Array, ...], gain: Array, first: int, found: tuple[Array, ...]) -> None:
    """Fill found with the loops given, both a, b, c and d (n, cases, ...), their terms closed by gain (n, cases, t).

    first: channel from which on the terms stand.
    """
    a, b, c, d = given
    new_a, new_b, new_c, new_d = found
    size, states, inputs = gain.shape[2], a.shape[3], b.shape[3]
    last = first + size
    returned, answers = np.empty((size, size)), np.empty((size, states + inputs))
    for n in range(a.shape[0]):
        for case in range(a.shape[1]):
            for k in range(size):
                g = gain[n, case, k]
                for j in range(size):
                    returned[k, j] = (1.0 if j == k else 0.0) - g * d[n, case, first + k, first + j]
                for j in range(states):
                    answers[k, j] = g * c[n, case, first + k, j]
                for j in range(inputs):
                    answers[k, states + j] = g * d[n, case, first + k, j]
            solve(returned, answers)
            on_states, on_outputs = b[n, case, :, first:last], d[n, case, :, first:last]
            add_product(a[n, case], on_states, answers, 0, new_a[n, case])
            add_product(b[n, case], on_states, answers, states, new_b[n, case])
            add_product(c[n, case], on_outputs, answers, 0, new_c[n, case])
            add_product(d[n, case], on_outputs, answers, states, new_d[n, case])


close_all = keep_file(numba.njit(**OPTIONS, nogil=True)(close_all), Path(__file__))
