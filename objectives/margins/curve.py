"""Geometry of the curve T(e^{jwh}) of one loop, compiled: all that margins are read off.

With T from the injected to the commanded signal, S = 1 + T and L = -T/(1 + T), every margin is a distance of this curve from a
point of the real axis or a crossing of a line:

    |1 + L| >= r          distance |T + 1|, its peak the sensitivity, |T| the complementary one, |T + (1 + sigma)/2| a disk
    L real, negative      T real, above 0 (the gain may rise by (1 + T)/T) or below -1 (it may fall)
    |L| = 1               Re T = -1/2, with arg L = -2 atan(2 Im T)

T is a sum of modes r/(z - p), so it and its derivatives cost n operations at any frequency, and a peak or a crossing is refined
by Newton's method kept inside a bracket. On the circle a curve of n modes is real, or on the line, at n frequencies at most.

All compiled functions stand in this file, which names what is kept of them; what the two entries call is inlined into each, so
that both give the same bits whether they were compiled by this process or loaded, and in which order.
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plant.backends import cache
from plant.backends.cache import keep_file
from plant.backends.compiling import inliner, kernel

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# What a root is sought of: the imaginary part, the real part plus a level, the slope of the distance from minus a level, the
# square of the modulus less a level.
IMAGINARY, REAL, PEAK, SQUARE = 0, 1, 2, 3
# Relative change of w by which Newton's method comes to a root for good, for the next one is its square; and steps that surely
# get there by halving.
CLOSE, STEPS = 1e-8, 60
# A resonance whose half-width is less than this share of its frequency may slip through the grid: it gets points of its own, in
# half-widths from its middle.
NARROW = 0.05
OFFSETS = (-3.0, -1.0, -0.3, 0.0, 0.3, 1.0, 3.0)
# A peak below this share of the highest point on the grid, squared, does not become the highest by being refined.
RIVAL = 0.5

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract", "reassoc", "arcp", "nsz", "afn"}}
inlined, allocating = inliner(OPTIONS), inliner(OPTIONS, allocates=True)


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a function that is called from Python and keep it."""
    return keep_file(kernel(OPTIONS)(function), Path(__file__))


@inlined
def value_and_slopes(w: float, poles: Complex, residues: Complex, h: float) -> tuple[complex, complex, complex]:
    """Return T, T' and T'', derivatives by w, at z = e^{jwh}."""
    z = complex(math.cos(w * h), math.sin(w * h))
    t = first = second = 0.0j
    for k in range(len(poles)):
        d = z - poles[k]
        step = d.conjugate() * (1.0 / (d.real * d.real + d.imag * d.imag))
        part = residues[k] * step
        t += part
        part *= step
        first -= part
        second += 2.0 * part * step
    by_w = 1j * h * z
    return t, first * by_w, second * by_w * by_w + first * 1j * h * by_w


@inlined
def sought(
    w: float, poles: Complex, residues: Complex, h: float, kind: int, level: float
) -> tuple[float, float, complex, complex]:
    """Return the function of `root` and T, with their derivatives by w."""
    t, first, second = value_and_slopes(w, poles, residues, h)
    if kind == IMAGINARY:
        return t.imag, first.imag, t, first
    if kind == REAL:
        return t.real + level, first.real, t, first
    along = (t.real + level) * first.real + t.imag * first.imag
    if kind == PEAK:
        bend = (t.real + level) * second.real + t.imag * second.imag
        return along, first.real * first.real + first.imag * first.imag + bend, t, first
    return t.real * t.real + t.imag * t.imag - level, 2.0 * along, t, first


@inlined
def root(
    low: float,
    high: float,
    rising: bool,
    start: float,
    poles: Complex,
    residues: Complex,
    h: float,
    kind: int,
    level: float,
) -> tuple[float, complex]:
    """Return the root in (low, high), and T there, by Newton's method.

    It bisects where a step would leave the interval. rising: the sign goes from - to +.
    start: where to look first, the middle where that is not between.
    """
    w = start if low < start < high else 0.5 * (low + high)
    t = 0.0j
    for _ in range(STEPS):
        f, slope, t, by_w = sought(w, poles, residues, h, kind, level)
        if (f > 0.0) == rising:
            high = w
        else:
            low = w
        following = w - f / slope if slope != 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        step = following - w
        w = following
        if abs(step) <= CLOSE * high:
            t += step * by_w
            break
    return w, t


@inlined
def resonances(first: float, last: float, poles: Complex, h: float, extra: Array) -> int:
    """Fill in points on every resonance too narrow for the grid.

    They are sorted and between two frequencies; returns their number.
    """
    n = 0
    for p in poles:
        if p.imag > 0.0:
            middle, width = math.atan2(p.imag, p.real) / h, -math.log(abs(p)) / h
            if width < NARROW * middle:
                for offset in OFFSETS:
                    w = middle + offset * width
                    if first < w < last:
                        i = n
                        while i > 0 and extra[i - 1] > w:
                            extra[i] = extra[i - 1]
                            i -= 1
                        extra[i] = w
                        n += 1
    return n


@allocating
def merged(grid: Array, poles: Complex, h: float) -> Array:
    """Columns (3, n): frequencies w of the grid (3, f) and of narrow resonances in order, cos wh, sin wh."""
    extra = np.empty(len(OFFSETS) * len(poles))
    n, f = resonances(grid[0, 1], grid[0, -1], poles, h, extra), grid.shape[1]
    if n == 0:
        return grid
    out = np.empty((3, f + n))
    i = j = 0
    for k in range(f + n):
        if i < f and (j == n or grid[0, i] <= extra[j]):
            out[0, k], out[1, k], out[2, k] = grid[0, i], grid[1, i], grid[2, i]
            i += 1
        else:
            out[0, k], out[1, k], out[2, k] = extra[j], math.cos(extra[j] * h), math.sin(extra[j] * h)
            j += 1
    return out


@inlined
def sample(points: Array, poles: Complex, residues: Complex, t: Array) -> None:
    """Fill t (2, f) with real and imaginary part of T; the loop over frequencies is the inner one, for SIMD.

    Conjugate poles are taken together: (r (z - p*) + r* (z - p)) / ((z - p)(z - p*)), in differences, which lose nothing near p.
    """
    x, y, re, im = points[1], points[2], t[0], t[1]
    for i in range(len(x)):
        re[i] = im[i] = 0.0
    for k in range(len(poles)):
        a, b, c, d = poles[k].real, poles[k].imag, residues[k].real, residues[k].imag
        if b == 0.0:
            for i in range(len(x)):
                u = x[i] - a
                s = c / (u * u + y[i] * y[i])
                re[i] += s * u
                im[i] -= s * y[i]
        elif b > 0.0:
            for i in range(len(x)):
                u, v, w = x[i] - a, y[i] - b, y[i] + b
                top, rise = 2.0 * (c * u - b * d), 2.0 * c * y[i]
                under, skew = u * u - v * w, 2.0 * u * y[i]
                s = 1.0 / (under * under + skew * skew)
                re[i] += s * (top * under + rise * skew)
                im[i] += s * (rise * under - top * skew)


@allocating
def highest(points: Array, t: Array, poles: Complex, residues: Complex, h: float, level: float) -> tuple[float, float]:
    """Frequency and height of the highest peak of |T + level|."""
    w, n = points[0], points.shape[1]
    square = np.empty(n)
    for i in range(n):
        square[i] = (t[0, i] + level) ** 2 + t[1, i] ** 2
    best = best_w = 0.0
    for i in range(n):
        if square[i] > best:
            best, best_w = square[i], w[i]
    rival = RIVAL * best
    for i in range(n):
        if square[i] >= rival:
            left, right = max(i - 1, 0), min(i + 1, n - 1)
            if square[i] >= square[left] and square[i] >= square[right]:
                slope, bend, _, _ = sought(w[i], poles, residues, h, PEAK, level)
                low, high = (w[i], w[right]) if slope > 0.0 else (w[left], w[i])
                if low < high:
                    start = w[i] - slope / bend
                    peak, top = root(low, high, False, start, poles, residues, h, PEAK, level)
                    height = (top.real + level) ** 2 + top.imag**2
                    if height > best:
                        best, best_w = height, peak
    return best_w, math.sqrt(best)


@inlined
def crossings(
    w: Array, part: Array, poles: Complex, residues: Complex, h: float, kind: int, level: float, out: Array
) -> None:
    """Fill `out` (n, 2) where a part of T crosses minus a level.

    A row is w and the other part of T; parts are the real and the imaginary one.
    """
    count = 0
    for i in range(len(w) - 1):
        rising = part[i + 1] > -level
        if (part[i] > -level) != rising and count < len(out):
            start = w[i] - (part[i] + level) * (w[i + 1] - w[i]) / (part[i + 1] - part[i])
            at, t = root(w[i], w[i + 1], rising, start, poles, residues, h, kind, level)
            out[count, 0], out[count, 1] = at, t.real if kind == IMAGINARY else t.imag
            count += 1


@allocating
def read_curve(
    grid: Array, poles: Complex, residues: Complex, h: float, levels: Array, peaks: Array, crossed: Array, kinds: range
) -> None:
    """Read one loop; the grid (3, f), as of `merged`, starts at 0 and ends at pi/h, where T is real.

    peaks (levels, 2): w and height of the highest |T + level| of each level. crossed (2, n + 2, 2): of those of `kinds`, at
    IMAGINARY w and T where T is real, at REAL w and Im T where Re T = -1/2. Rows that are not used stay as they are.
    """
    points = merged(grid, poles, h)
    w, last = points[0], points.shape[1] - 1
    t = np.empty((2, last + 1))
    sample(points, poles, residues, t)
    for j in range(len(levels)):
        peaks[j, 0], peaks[j, 1] = highest(points, t, poles, residues, h, levels[j])
    for kind in kinds:
        begin = 0
        if kind == IMAGINARY:
            # At both ends the imaginary part vanishes; just inside it has the sign that its slope gives it.
            for end in range(2):
                i = end * last
                crossed[kind, end, 0], crossed[kind, end, 1] = w[i], t[0, i]
                _, slope, _ = value_and_slopes(w[i], poles, residues, h)
                t[1, i] = slope.imag if end == 0 else -slope.imag
            begin = 2
        level = 0.0 if kind == IMAGINARY else 0.5
        crossings(w, t[1 - kind], poles, residues, h, kind, level, crossed[kind, begin:])


@compiled
def read_all(
    grid: Array,
    poles: Complex,
    residues: Complex,
    stable: NDArray[np.bool_],
    h: float,
    levels: Array,
    peaks: Array,
    crossed: Array,
    real: bool,
    line: bool,
) -> None:
    """Read stable loops with poles (n, b) and residues (n, k, b); see `read_curve`.

    Each of the n has k channels; those that are not stable are left out.
    real, line: whether to look for where T is real, and for where Re T = -1/2.
    """
    kinds = range(IMAGINARY if real else REAL, REAL + 1 if line else REAL)
    for i in range(len(poles)):
        if stable[i]:
            for j in range(residues.shape[1]):
                read_curve(grid, poles[i], residues[i, j], h, levels, peaks[i, j], crossed[i, j], kinds)


@allocating
def highest_crossing(grid: Array, poles: Complex, residues: Complex, h: float, square: float) -> float:
    """Highest frequency at which |T|^2 falls to `square`; the end of the grid where it is above there, 0 where it never is."""
    points = merged(grid, poles, h)
    t = np.empty((2, points.shape[1]))
    sample(points, poles, residues, t)
    for i in range(points.shape[1] - 1, -1, -1):
        if t[0, i] ** 2 + t[1, i] ** 2 >= square:
            if i == points.shape[1] - 1:
                return points[0, i]
            return root(points[0, i], points[0, i + 1], False, points[0, i], poles, residues, h, SQUARE, square)[0]
    return 0.0


@compiled
def highest_crossings(
    grid: Array, poles: Complex, residues: Complex, stable: NDArray[np.bool_], h: float, square: float, out: Array
) -> None:
    """Fill `out` (n, k) with `highest_crossing` of the stable loops.

    The loops have poles (n, b) and residues (n, k, b).
    """
    for i in range(len(poles)):
        if stable[i]:
            for j in range(residues.shape[1]):
                out[i, j] = highest_crossing(grid, poles[i], residues[i, j], h, square)


def is_compiled() -> bool:
    """Return True if this file is compiled; else the first evaluation waits some 10 s.

    This process or an earlier one may have compiled it.
    """
    return cache.is_compiled(read_all) and cache.is_compiled(highest_crossings)
