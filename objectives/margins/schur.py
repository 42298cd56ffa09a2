"""Modes of many small real matrices, compiled: poles, what drives each mode and what it shows.

Householder's reduction to Hessenberg form, Francis's double-shift QR to a quasi-triangle (G. H. Golub, C. F. Van Loan, Matrix
Computations, 4th ed., Johns Hopkins 2013, sections 7.4 and 7.5), rotations that make its 2x2 blocks triangular, and back
substitution for the eigenvectors of the triangle on either side. Inputs and outputs are turned along, so no matrix of
eigenvectors is ever formed or inverted.

LAPACK takes five times as long for a matrix of 14 states, and rounds as the processor and its library please.
"""

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plant.backends.cache import keep_file
from plant.backends.compiling import inliner, kernel

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Relative size below which an entry under the diagonal is nothing, sweeps for each row after which a matrix is given up, and
# how many without success lead to shifts of another kind.
NEGLIGIBLE, SWEEPS, STUCK = 2.3e-16, 30, 10

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract", "reassoc", "nsz"}}
inlined, allocating = inliner(OPTIONS), inliner(OPTIONS, allocates=True)


@inlined
def reflect(rows: Array, v: Array, scale: float, first: int) -> None:
    """Reflect vectors, rows (m, n), at v (n,), which is 0 before `first`."""
    n = len(v)
    for i in range(len(rows)):
        along = 0.0
        for j in range(first, n):
            along += rows[i, j] * v[j]
        along *= scale
        for j in range(first, n):
            rows[i, j] -= along * v[j]


@allocating
def reduce(h: Array, b: Array, c: Array) -> None:
    """Reduce a matrix h (n, n) to Hessenberg form.

    Inputs b (u, n) and outputs c (o, n) go along with it.
    """
    n = len(h)
    v, along = np.zeros(n), np.empty(n)
    for k in range(n - 2):
        square = 0.0
        for i in range(k + 1, n):
            v[i] = h[i, k]
            square += v[i] * v[i]
        end = -math.copysign(math.sqrt(square), v[k + 1])
        half = square - end * v[k + 1]
        v[k] = 0.0
        v[k + 1] -= end
        if half > 0.0:
            scale = 1.0 / half
            along[:] = 0.0
            for i in range(k + 1, n):
                for j in range(k, n):
                    along[j] += v[i] * h[i, j]
            for i in range(k + 1, n):
                by = scale * v[i]
                for j in range(k, n):
                    h[i, j] -= by * along[j]
                if i > k + 1:
                    h[i, k] = 0.0
            reflect(h, v, scale, k + 1)
            reflect(b, v, scale, k + 1)
            reflect(c, v, scale, k + 1)


@inlined
def turn(rows: Array, count: int, k: int, width: int, x: float, y: float, z: float, q: float, r: float) -> None:
    """Reflect entries of the first `count` of some vectors, rows (m, n).

    The entries are k to k + width - 1.
    """
    for i in range(count):
        p = x * rows[i, k] + y * rows[i, k + 1]
        if width == 3:
            p += z * rows[i, k + 2]
            rows[i, k + 2] -= p * r
        rows[i, k] -= p
        rows[i, k + 1] -= p * q


@inlined
def sweep(h: Array, b: Array, c: Array, low: int, high: int, since: int) -> None:
    """One step of the double-shift QR on rows low to high: a bulge is made at the top and chased out at the bottom."""
    n = len(h)
    x, y, w = h[high, high], h[high - 1, high - 1], h[high, high - 1] * h[high - 1, high]
    if since % STUCK == 0:
        s = abs(h[high, high - 1]) + abs(h[high - 1, high - 2])
        x += 0.75 * s
        y, w = x, -0.4375 * s * s
    z = h[low, low]
    r, s = x - z, y - z
    f, g, e = (r * s - w) / h[low + 1, low] + h[low, low + 1], h[low + 1, low + 1] - z - r - s, h[low + 2, low + 1]
    for k in range(low, high):
        width = 3 if k < high - 1 else 2
        if k > low:
            f, g, e = h[k, k - 1], h[k + 1, k - 1], h[k + 2, k - 1] if width == 3 else 0.0
        size = abs(f) + abs(g) + abs(e)
        if size > 0.0:
            f, g, e = f / size, g / size, e / size
            s = math.copysign(math.sqrt(f * f + g * g + e * e), f)
            if k > low:
                h[k, k - 1], h[k + 1, k - 1] = -s * size, 0.0
                if width == 3:
                    h[k + 2, k - 1] = 0.0
            f += s
            x, y, z, q, r = f / s, g / s, e / s, g / f, e / f
            for j in range(k, n):
                p = h[k, j] + q * h[k + 1, j]
                if width == 3:
                    p += r * h[k + 2, j]
                    h[k + 2, j] -= p * z
                h[k, j] -= p * x
                h[k + 1, j] -= p * y
            turn(h, min(high, k + 3) + 1, k, width, x, y, z, q, r)
            turn(b, len(b), k, width, x, y, z, q, r)
            turn(c, len(c), k, width, x, y, z, q, r)


@inlined
def quasi_triangle(h: Array, b: Array, c: Array) -> bool:
    """Reduce a Hessenberg matrix h (n, n) to a quasi-triangle; False where that fails.

    It has 2x2 blocks; b and c go along.
    """
    high, low, since = len(h) - 1, 0, 0
    for _ in range(SWEEPS * len(h)):
        while high > 0:
            low = high
            while low > 0:
                if abs(h[low, low - 1]) <= NEGLIGIBLE * (abs(h[low, low]) + abs(h[low - 1, low - 1])):
                    h[low, low - 1] = 0.0
                    break
                low -= 1
            if low < high - 1:
                break
            high, since = low - 1, 0
        if high <= 0:
            return True
        since += 1
        sweep(h, b, c, low, high, since)
    return False


@inlined
def triangle(h: Array, t: Complex, b: Complex, c: Complex) -> None:
    """Fill t (n, n) with the triangle of a quasi-triangle h; its 2x2 blocks are turned, b (u, n) and c (o, n) along with them."""
    n = len(h)
    for i in range(n):
        for j in range(n):
            t[i, j] = h[i, j]
    for k in range(n - 1):
        below = h[k + 1, k]
        if below != 0.0:
            # Eigenvalues less the last diagonal entry: the first, by which the block is turned, and the second.
            p = 0.5 * (h[k, k] - h[k + 1, k + 1])
            square = p * p + below * h[k, k + 1]
            root = math.sqrt(abs(square))
            if square >= 0.0:
                large = p + math.copysign(root, p)
                first, second = complex(large, 0.0), complex(-below * h[k, k + 1] / large if large != 0.0 else 0.0, 0.0)
            else:
                first, second = complex(p, root), complex(p, -root)
            by = 1.0 / math.sqrt(first.real * first.real + first.imag * first.imag + below * below)
            e, s = first * by, below * by
            for j in range(k, n):
                one, other = t[k, j], t[k + 1, j]
                t[k, j] = e.conjugate() * one + s * other
                t[k + 1, j] = e * other - s * one
            for j in range(len(b)):
                one, other = b[j, k], b[j, k + 1]
                b[j, k] = e.conjugate() * one + s * other
                b[j, k + 1] = e * other - s * one
            turn_pair(t, k + 2, k, e, s)
            turn_pair(c, len(c), k, e, s)
            # From h, where an earlier turn has left it as it was: conjugate to the last bit.
            t[k, k], t[k + 1, k + 1], t[k + 1, k] = h[k + 1, k + 1] + first, h[k + 1, k + 1] + second, 0.0


@inlined
def turn_pair(rows: Complex, count: int, k: int, e: complex, s: float) -> None:
    """Rotate entries k, k + 1 of the first `count` rows (m, n)."""
    for i in range(count):
        one, other = rows[i, k], rows[i, k + 1]
        rows[i, k] = one * e + other * s
        rows[i, k + 1] = other * e.conjugate() - one * s


@inlined
def divided(top: complex, under: complex, least: float) -> complex:
    """Return the quotient of two numbers; a divisor smaller than `least` counts as `least`."""
    if abs(under.real) + abs(under.imag) < least:
        return top * (1.0 / least)
    return top * under.conjugate() * (1.0 / (under.real * under.real + under.imag * under.imag))


@inlined
def right_of(t: Complex, k: int, least: float, x: Complex) -> float:
    """Fill x (n,) with a triangle's right eigenvector of its k-th pole.

    It is 1 at k and 0 behind; returns its length squared.
    """
    x[k] = 1.0
    square = 1.0
    for i in range(k - 1, -1, -1):
        total = t[i, k]
        for j in range(i + 1, k):
            total += t[i, j] * x[j]
        x[i] = divided(-total, t[i, i] - t[k, k], least)
        square += x[i].real * x[i].real + x[i].imag * x[i].imag
    return square


@inlined
def left_of(t: Complex, k: int, least: float, y: Complex) -> float:
    """Fill y (n,) with a triangle's left eigenvector of its k-th pole.

    It is 1 at k and 0 before; returns its length squared.
    """
    n = len(t)
    for j in range(k + 1, n):
        y[j] = t[k, j]
    y[k] = 1.0
    square = 1.0
    for i in range(k + 1, n):
        # Row by row: what entry i adds to those behind it.
        y[i] = divided(-y[i], t[i, i] - t[k, k], least)
        square += y[i].real * y[i].real + y[i].imag * y[i].imag
        for j in range(i + 1, n):
            y[j] += y[i] * t[i, j]
    return square


def split(
    a: Array, b: Array, c: Array, radius: float, poles: Complex, driven: Complex, shown: Complex, spread: Array
) -> None:
    """Split matrices a (m, n, n) into modes.

    A left eigenvector times its right eigenvector is 1, and what belongs to conjugate poles is conjugate. Of a matrix
    with a pole on or outside the circle only the poles are computed; driven and shown stay as they are, and spread is
    0.

    Args:
        a: Matrices (m, n, n).
        b: Inputs (m, n, u).
        c: Outputs (m, o, n).
        radius: Radius of the circle.
        poles: Poles (m, n), filled in.
        driven: Left eigenvectors times b (m, n, u), filled in.
        shown: c times right eigenvectors (m, o, n), filled in.
        spread: Norm (m,) of the inverse of the matrix of right eigenvectors of length 1, filled in; NaN for a matrix
            that could not be split, whose poles are wrong.
    """
    n, u, o = a.shape[1], b.shape[2], c.shape[1]
    h, inputs, outputs = np.empty((n, n)), np.empty((u, n)), np.empty((o, n))
    t, sent, seen = np.empty((n, n), np.complex128), np.empty((u, n), np.complex128), np.empty((o, n), np.complex128)
    x, y = np.empty(n, np.complex128), np.empty(n, np.complex128)
    for row in range(len(a)):
        largest = 1e-280
        for i in range(n):
            for j in range(n):
                h[i, j] = a[row, i, j]
            for j in range(u):
                inputs[j, i] = b[row, i, j]
            for j in range(o):
                outputs[j, i] = c[row, j, i]
        reduce(h, inputs, outputs)
        done = quasi_triangle(h, inputs, outputs)
        for i in range(n):
            for j in range(i, n):
                largest = max(largest, abs(h[i, j]))
            for j in range(u):
                sent[j, i] = inputs[j, i]
            for j in range(o):
                seen[j, i] = outputs[j, i]
        triangle(h, t, sent, seen)
        total, inside = 0.0, True
        for k in range(n):
            poles[row, k] = t[k, k]
            inside = inside and abs(t[k, k]) < radius
        if done and not inside:
            spread[row] = 0.0
            continue
        for k in range(n):
            if t[k, k].imag >= 0.0:
                square = right_of(t, k, NEGLIGIBLE * largest, x) * left_of(t, k, NEGLIGIBLE * largest, y)
                for j in range(u):
                    part = 0.0j
                    for i in range(k, n):
                        part += y[i] * sent[j, i]
                    driven[row, k, j] = part
                for j in range(o):
                    part = 0.0j
                    for i in range(k + 1):
                        part += seen[j, i] * x[i]
                    shown[row, j, k] = part
                total += square if t[k, k].imag == 0.0 else 2.0 * square
            else:
                for j in range(u):
                    driven[row, k, j] = driven[row, k - 1, j].conjugate()
                for j in range(o):
                    shown[row, j, k] = shown[row, j, k - 1].conjugate()
        spread[row] = math.sqrt(total) if done else np.nan


split = keep_file(kernel(OPTIONS)(split), Path(__file__))
