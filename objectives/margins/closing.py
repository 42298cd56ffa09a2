"""The nonlinear terms of linearized loops closed, each as a gain, compiled: w = g s for every candidate and amplitude.

With s = C_s x + D_s u + D_sw w, the terms give w = (1 - g D_sw)^{-1} g (C_s x + D_s u), which is what all other rows then have
of w. In NumPy the products of so many small matrices, and the memory between them, take three times as long.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.linearise import LinearLoops
from plant.backends.cache import keep_file
from plant.backends.compiling import inliner, kernel, read_only

Array = NDArray[np.float64]

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract", "nsz"}}
inlined = inliner(OPTIONS)


def close_terms(loops: LinearLoops, gain: Array) -> LinearLoops:
    """Close the nonlinear terms as w = gain s, gains (..., terms); the result keeps w as an input that is added to them.

    Leading axes of the loops and of the gains broadcast. A term that its own output feeds with a loop gain of 1 leaves infinite
    entries.
    """
    if not loops.n_terms:
        return loops
    leading = np.broadcast_shapes(loops.a.shape[:-2], gain.shape[:-1])
    rows = _two(leading)
    given = [
        read_only(part.reshape(*_two(part.shape[:-2]), *part.shape[-2:]))
        for part in (loops.a, loops.b, loops.c, loops.d)
    ]
    out = [np.empty((*rows, *part.shape[-2:])) for part in given]
    close_all(
        tuple(given), read_only(gain.reshape(*_two(gain.shape[:-1]), loops.n_terms)), loops.terms.start, tuple(out)
    )
    a, b, c, d = (part.reshape(*leading, *part.shape[2:]) for part in out)
    return replace(loops, a=a, b=b, c=c, d=d)


def _two(leading: tuple[int, ...]) -> tuple[int, ...]:
    """Return leading axes as two, ones in front."""
    return (*(1,) * (2 - len(leading)), *leading)


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
def add_product(given: Array, of_terms: Array, answers: Array, start: int, out: Array) -> None:
    """Fill `out` (m, p) with given (m, p) plus of_terms times answers.

    of_terms is (m, t); the columns of answers (t, ...) count from `start` on.
    """
    for i in range(given.shape[0]):
        for j in range(given.shape[1]):
            total = given[i, j]
            for k in range(of_terms.shape[1]):
                total += of_terms[i, k] * answers[k, start + j]
            out[i, j] = total


def close_all(given: tuple[Array, ...], gain: Array, first: int, out: tuple[Array, ...]) -> None:
    """Fill `out` with the given loops, terms closed by gain (n, cases, t).

    Both are a, b, c and d (n, cases, ...).
    first: channel from which on the terms stand. A single value holds for every n, or for every case.
    """
    whole_a, whole_b, whole_c, whole_d = given
    new_a, new_b, new_c, new_d = out
    size, states, inputs = gain.shape[2], whole_a.shape[3], whole_b.shape[3]
    last = first + size
    returned, answers = np.empty((size, size)), np.empty((size, states + inputs))
    for n in range(new_a.shape[0]):
        for case in range(new_a.shape[1]):
            a = whole_a[n % len(whole_a), case % whole_a.shape[1]]
            b = whole_b[n % len(whole_b), case % whole_b.shape[1]]
            c = whole_c[n % len(whole_c), case % whole_c.shape[1]]
            d = whole_d[n % len(whole_d), case % whole_d.shape[1]]
            gains = gain[n % len(gain), case % gain.shape[1]]
            for k in range(size):
                g = gains[k]
                for j in range(size):
                    returned[k, j] = (1.0 if j == k else 0.0) - g * d[first + k, first + j]
                for j in range(states):
                    answers[k, j] = g * c[first + k, j]
                for j in range(inputs):
                    answers[k, states + j] = g * d[first + k, j]
            solve(returned, answers)
            on_states, on_outputs = b[:, first:last], d[:, first:last]
            add_product(a, on_states, answers, 0, new_a[n, case])
            add_product(b, on_states, answers, states, new_b[n, case])
            add_product(c, on_outputs, answers, 0, new_c[n, case])
            add_product(d, on_outputs, answers, states, new_d[n, case])


close_all = keep_file(kernel(OPTIONS)(close_all), Path(__file__))
