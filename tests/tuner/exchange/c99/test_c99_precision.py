"""Arrays of a precision calculate as Python does with floats, the signs of zeros included: golden vectors compare bits."""

from itertools import product

import numpy as np
import pytest

from plant.backends.c_code import DOUBLE, FLOAT
from plant.primitives import floor, maximum, minimum, sign
from tuner.exchange.c99.precision import rebinder

NUMBERS = (0.0, -0.0, 0.5, -0.5, 1.0, -1.0, -1.5)


def lesser(a, b):
    return minimum(a, b)


def greater(a, b):
    return maximum(a, b)


def whole(a, _):
    return floor(a)


def direction(a, _):
    return sign(a)


@pytest.mark.parametrize("real", [FLOAT, DOUBLE], ids=["float", "double"])
@pytest.mark.parametrize("function", [lesser, greater, whole, direction])
def test_functions_of_arrays_have_the_bits_of_python(function, real):
    pairs = list(product(NUMBERS, repeat=2))
    expected = np.array([float(function(*pair)) for pair in pairs], dtype=real.dtype)
    first, second = np.array(pairs, dtype=real.dtype).T
    found = np.asarray(rebinder(real)(function)(first, second), dtype=real.dtype)
    assert found.tobytes() == expected.tobytes()
