"""Describing functions of a law's nonlinear terms, from the functions that fly.

For an odd memoryless f the first harmonic of f(A sin t) is N(A) A sin t with

    N(A) = 4/(pi A) int_0^(pi/2) f(A sin t) sin t dt

so around an oscillation of amplitude A the term acts as the gain N(A). A. Gelb, W. E. Vander Velde, Multiple-Input Describing
Functions and Nonlinear System Design, McGraw-Hill 1968, section 2.2. A small perturbation of a state away from rest sees the
slope f' instead, which can exceed every N (1.5 against 0.93 for |s|^(1/2) sat s), so the steepest slope is a case of its own.

Signals swing about 0, as they do under laws that leave no steady error. Undeclared nonlinearities, such as the tracking
differentiator of ADRC, and limits act as they do on small signals.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.period import Term
from plant.backends import array
from plant.records import flatten

Array = NDArray[np.float64]

# Panels of [0, pi/2] and Gauss-Legendre nodes on each. They shrink towards 0, where terms like |s|^(1/2) have no series, and are
# short enough that a kink costs 1e-4 at most.
PANELS = (0.0, 0.01, 0.05, 0.15, 0.3, 0.5, 0.7, 0.9, 1.1, 1.3, 0.5 * np.pi)
NODES = 8
# Signal at which the slope at rest is read: |s|^(3/2) is left with 1e-50 of it. Where that slope has no end, as at a root or a
# jump, a ramp as wide as REST, far below every width that a law's gains can ask for, stands for it.
VANISHING, REST = 1e-100, 1e-9
# Signals between which slopes are taken in search of the steepest. About it they are taken again, so many times between so many
# points: from 15 % of the signal apart down to 2e-7, where what lies between costs 1e-7 of the slope and rounding 1e-9.
SLOPE_GRID = np.concatenate([[-REST, REST], np.geomspace(1e-6, 1e2, 385)])
SLOPE_ZOOMS, SLOPE_SHARES = 6, np.linspace(0.0, 1.0, 25)


@dataclass(frozen=True)
class Case:
    """Amplitude of the signals of the nonlinear terms.

    amplitude: of all of them at once, each in its own unit (rad/s or m/s for a sliding variable); 0 for vanishing ones, None
    for the steepest slope of each term.
    """

    amplitude: float | None

    @property
    def label(self) -> str:
        """Words for reports."""
        if self.amplitude is None:
            return "steepest slope"
        return "small signals" if self.amplitude == 0.0 else f"amplitude {self.amplitude:.3g}"


DEFAULT_CASES = tuple(Case(a) for a in (0.0, 0.02, 0.1, 0.5, 2.0, None))


@cache
def _rule() -> tuple[Array, Array]:
    """Sin t and weight sin t dt 4/pi at the nodes."""
    node, weight = np.polynomial.legendre.leggauss(NODES)
    low, high = np.array(PANELS[:-1])[:, None], np.array(PANELS[1:])[:, None]
    angle = 0.5 * (low + high) + 0.5 * (high - low) * node
    return np.sin(angle).ravel(), (0.5 * (high - low) * weight * np.sin(angle) * 4.0 / np.pi).ravel()


def describing_function(function: Callable[..., Any], constants: Any, amplitudes: Array) -> Array:
    """N(A) (n, amplitudes) of a term for constants with leaves (n, 1, 1); amplitude 0 gives the slope at rest."""
    bound, (sine, weight) = array.rebinder()(function), _rule()
    a = np.where(amplitudes > 0.0, amplitudes, REST)[:, None]
    swung = np.sum(bound(a * sine, constants) * weight, axis=-1) / a[:, 0]
    at_rest = np.broadcast_to(bound(VANISHING, constants), (*swung.shape[:-1], 1, 1))[..., 0] / VANISHING
    return np.where((amplitudes == 0.0) & (at_rest <= 2.0 * swung), at_rest, swung)


def steepest_slope(function: Callable[..., Any], constants: Any) -> Array:
    """Largest slope (n,) of a term for constants with leaves (n, 1, 1); a jump at 0 has that of a ramp as wide as rest."""
    bound = array.rebinder()(function)
    s, steepest = SLOPE_GRID[None, None], np.full(1, -np.inf)
    for _ in range(1 + SLOPE_ZOOMS):
        slope = np.diff(bound(s, constants), axis=-1) / np.diff(s, axis=-1)
        steepest = np.maximum(steepest, np.max(slope, axis=(-2, -1)))
        s = _closer(s, np.argmax(slope, axis=-1))
    return steepest


def _closer(s: Array, at: NDArray[np.intp]) -> Array:
    """Return finer signals (n, 1, points) about the interval `at` (n, 1) of signals.

    Neighbors are included, where a corner may stand.
    """
    rows = np.minimum(np.arange(len(at)), len(s) - 1)[:, None]
    low, high = (s[rows, 0, np.minimum(np.maximum(at + step, 0), s.shape[-1] - 1)][..., None] for step in (-1, 2))
    # Below rest a root is steeper without end.
    low = np.maximum(low, REST)
    return low + (high - low) * SLOPE_SHARES


def term_gains(terms: Sequence[Term], constants: Any, n: int, cases: tuple[Case, ...]) -> Array:
    """Return the gains (n, cases, terms) that represent nonlinear terms.

    Each term is of an axis of constants for n gains rows.
    """
    out = np.empty((n, len(cases), len(terms)))
    for j, term in enumerate(terms):
        of_axis = getattr(constants, term.axis)
        alike = (i for i in range(j) if _same(terms[i], term, getattr(constants, terms[i].axis), of_axis))
        i = next(alike, None)
        out[:, :, j] = _case_gains(term, of_axis, cases) if i is None else out[:, :, i]
    return out


def _same(one: Any, other: Any, of_one: Any, of_other: Any) -> bool:
    """Return True if two terms are one function under equal constants.

    So are those on axes that share their gains.
    """
    return one.nonlinearity is other.nonlinearity and all(
        np.array_equal(a, b) for a, b in zip(flatten(of_one), flatten(of_other), strict=True)
    )


def _case_gains(term: Any, constants: Any, cases: tuple[Case, ...]) -> Array:
    """Gains (n, cases) that represent one term."""
    function = term.nonlinearity.function
    amplitudes = np.array([case.amplitude for case in cases if case.amplitude is not None])
    swept = describing_function(function, constants, amplitudes)
    steep = [steepest_slope(function, constants)] if len(amplitudes) < len(cases) else []
    gains, taken = [*np.moveaxis(swept, -1, 0), *steep], iter(range(len(amplitudes)))
    chosen = [-1 if case.amplitude is None else next(taken) for case in cases]
    return np.stack(np.broadcast_arrays(*[gains[i] for i in chosen]), axis=-1)
