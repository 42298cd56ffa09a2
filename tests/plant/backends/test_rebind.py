"""Rebinding: same code, other names; what a model function must not do is refused."""

import pytest

from plant.backends.rebind import Rebinder
from plant.primitives import sqrt

OFFSET = 2.0


def inner(a):
    return sqrt(a) + OFFSET


def outer(a):
    return inner(a) * inner(4.0)


def uses_builtin(a):
    return abs(a)


def make(step):
    def closed(a):
        return step(a) + 1.0

    return closed


def fake(**changed):
    names = dict.fromkeys(
        [
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
        ],
    )
    return {**names, **changed}


def test_called_functions_are_rebound_too_and_the_original_is_untouched():
    bound = Rebinder(fake(sqrt=lambda a: 100.0))(outer)
    assert bound(9.0) == 102.0 * 102.0
    assert outer(9.0) == 5.0 * 4.0


def test_functions_in_closures_are_rebound():
    bound = Rebinder(fake(sqrt=lambda a: 7.0))(make(inner))
    assert bound(1.0) == 10.0


def test_each_function_is_bound_once_and_wrapped():
    seen = []

    def wrap(function):
        seen.append(function.__name__)
        return function

    bind = Rebinder(fake(sqrt=abs), wrap)
    assert bind(outer) is bind(outer)
    assert seen == ["inner", "outer"]
    assert {path.name for path in bind.sources} == {"test_rebind.py"}


def test_builtins_with_another_meaning_on_arrays_are_refused():
    with pytest.raises(TypeError, match="'abs'"):
        Rebinder(fake())(uses_builtin)


def test_a_function_may_be_stood_in_for_by_what_is_called_as_it_is():
    bound = Rebinder(fake(sqrt=lambda a: 100.0), stand_ins={inner: lambda a: a + 1.0})(outer)
    assert bound(9.0) == 10.0 * 5.0
    assert outer(9.0) == 5.0 * 4.0
