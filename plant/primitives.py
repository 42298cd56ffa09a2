"""The mathematical names that model functions may use, in their plain-Python meaning.

A model function is a plain function of scalars. It takes its mathematics from here and from nowhere else, so that a
backend turns it into array, SIMD or symbolic code by rebinding these names (`plant.backends`). There is no `if` on a
value in a model function: `select` chooses, and both choices are always evaluated.
"""

from math import asin, atan2, cos, exp, floor, log, sin, sqrt, tan, tanh

__all__ = [
    "absolute",
    "asin",
    "atan2",
    "both",
    "clip",
    "cos",
    "either",
    "exp",
    "floor",
    "hypot",
    "log",
    "maximum",
    "minimum",
    "select",
    "sign",
    "sin",
    "sqrt",
    "tan",
    "tanh",
]


def absolute(a: float) -> float:
    """Return |a|."""
    return abs(a)


def minimum(a: float, b: float) -> float:
    """Return the smaller of a and b."""
    return min(a, b)


def maximum(a: float, b: float) -> float:
    """Return the larger of a and b."""
    return max(a, b)


def select(condition: bool, if_true: float, if_false: float) -> float:
    """Return if_true where condition holds, else if_false; both are evaluated."""
    return if_true if condition else if_false


def clip(a: float, low: float, high: float) -> float:
    """Return a limited to [low, high]."""
    return min(max(a, low), high)


def both(a: bool, b: bool) -> bool:
    """Return the logical and of two conditions."""
    return a & b


def either(a: bool, b: bool) -> bool:
    """Return the logical or of two conditions."""
    return a | b


def hypot(a: float, b: float) -> float:
    """Return the length of (a, b)."""
    return sqrt(a * a + b * b)


def sign(a: float) -> float:
    """Return -1, 0 or 1 with the sign of a."""
    return float(a > 0.0) - float(a < 0.0)
