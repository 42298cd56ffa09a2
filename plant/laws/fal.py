"""Han's fal for the exponents that ADRC uses, scaled to the slope 1 in its linear zone.

    fal(e, a, delta) = |e|^a sgn e outside |e| <= delta, e/delta^(1-a) inside
    delta^(1-a) fal(e, a, delta) = e max(1, |e|/delta)^(a-1)

J. Han, IEEE Trans. Ind. Electron. 56(3), 2009, pp. 900-906. The scaled form needs square roots only, has no division by small
numbers, and is e itself, to the last bit, inside.
"""

from plant.primitives import absolute, maximum, sqrt


def beyond(e: float, delta: float) -> float:
    """max(1, |e|/delta)."""
    return maximum(1.0, absolute(e) / delta)


def fal_1_4(e: float, delta: float) -> float:
    """delta^(3/4) fal(e, 1/4, delta)."""
    root = sqrt(beyond(e, delta))
    return e / (root * sqrt(root))


def fal_1_2(e: float, delta: float) -> float:
    """delta^(1/2) fal(e, 1/2, delta)."""
    return e / sqrt(beyond(e, delta))


def fal_3_4(e: float, delta: float) -> float:
    """delta^(1/4) fal(e, 3/4, delta)."""
    return e / sqrt(sqrt(beyond(e, delta)))


def fal_3_2(e: float, delta: float) -> float:
    """delta^(-1/2) fal(e, 3/2, delta)."""
    return e * sqrt(beyond(e, delta))
