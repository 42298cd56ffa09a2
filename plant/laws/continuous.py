"""Continuous-time form of a law, for proofs and designs that need matrices; nothing in this file flies.

    x' = a x + b (r, y, y', known),   (u, S) = c x + d (r, y, y', known)

u is in acceleration units (b0 times the command), `known` is the delivered acceleration in the law's model, S the sliding
variable. A part of the feedback that grows slower than S is left out and counted apart (`Law.sector`); a linear law has S = 0.
"""

from typing import NamedTuple

Matrix = tuple[tuple[float, ...], ...]


class ContinuousForm(NamedTuple):
    """The matrices a (n, n), b (n, 4), c (2, n), d (2, 4) of a law with n states, as rows of numbers."""

    a: Matrix
    b: Matrix
    c: Matrix
    d: Matrix


def on_observer(polynomial: tuple[float, float, float], c: Matrix, d: Matrix) -> ContinuousForm:
    """Return the form of a feedback c (2, 3), d (2, 4) on the states z1, z2, z3 of a linear extended state observer.

    polynomial: the observer's gains (b1, b2, b3), coefficients of s^3 + b1 s^2 + b2 s + b3.
    """
    b1, b2, b3 = polynomial
    a = ((-b1, 1.0, 0.0), (-b2, 0.0, 1.0), (-b3, 0.0, 0.0))
    b = ((0.0, b1, 0.0, 0.0), (0.0, b2, 0.0, 1.0), (0.0, b3, 0.0, 0.0))
    return ContinuousForm(a, b, c, d)
