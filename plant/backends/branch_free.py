"""Primitives that both compilers of kernels inline unchanged.

`plant.primitives` itself is for plain Python: `sign` there turns conditions into floats, which a compiler of single precision
would widen, so each backend brings its own.
"""

from typing import Any


def absolute(a: Any) -> Any:
    """Return |a|."""
    return abs(a)


def minimum(a: Any, b: Any) -> Any:
    """Return the smaller of a and b."""
    return min(a, b)


def maximum(a: Any, b: Any) -> Any:
    """Return the larger of a and b."""
    return max(a, b)


def clip(a: Any, low: Any, high: Any) -> Any:
    """Return a limited to [low, high]."""
    return min(max(a, low), high)


def select(condition: Any, if_true: Any, if_false: Any) -> Any:
    """Return if_true where condition holds, else if_false."""
    return if_true if condition else if_false


def both(a: Any, b: Any) -> Any:
    """Return the logical and of two conditions."""
    return a & b


def either(a: Any, b: Any) -> Any:
    """Return the logical or of two conditions."""
    return a | b


FUNCTIONS = (absolute, minimum, maximum, clip, select, both, either)
