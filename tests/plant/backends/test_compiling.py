"""Inlined functions and kernels: what becomes machine code, and Python's garbage collector while numba compiles."""

import gc
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import types
from numba.extending import intrinsic

from plant.backends.compiling import inliner, kernel


def watched(seen) -> Any:
    """A compiled function that returns its number; `seen` gets whether the collector was at work when it was compiled."""

    @intrinsic
    def same(_, number):
        seen.append(gc.isenabled())
        return number(number), lambda _context, _builder, _signature, arguments: arguments[0]

    return same


@inliner({})
def halved(x):
    return 0.5 * x


@inliner({})
def pair(x):
    return np.full(2, x)


@inliner({}, allocates=True)
def allocated_pair(x):
    return np.full(2, x)


def test_an_inlined_function_computes_in_its_callers_only():
    quarter = kernel({})(lambda x: halved(halved(x)))
    assert quarter(3.0) == 0.75
    (inlined,) = halved.overloads.values()
    (entry,) = quarter.overloads.values()
    engine = entry.library.codegen._engine
    assert engine.is_symbol_defined(entry.fndesc.llvm_func_name)
    assert not engine.is_symbol_defined(inlined.fndesc.llvm_func_name)
    assert halved.signatures == [(types.float64,)]
    with pytest.raises(TypeError, match="must be str"):
        halved(3.0)


def test_an_inlined_function_that_makes_arrays_must_say_so():
    assert kernel({})(lambda x: allocated_pair(x).sum())(3.0) == 6.0
    with pytest.raises(numba.TypingError):
        kernel({})(lambda x: pair(x).sum())(3.0)


@pytest.mark.parametrize("enabled", [True, False])
@pytest.mark.parametrize("fails", [True, False])
def test_the_collector_rests_while_a_kernel_is_compiled_and_is_then_as_before(enabled, fails):
    seen = []
    same = watched(seen)
    function = (lambda x: same(x) + "") if fails else (lambda x: same(x) + 1)
    if not enabled:
        gc.disable()
    try:
        try:
            kernel({})(function)(np.int64(2))
        except numba.TypingError:
            assert fails
        after = gc.isenabled()
    finally:
        gc.enable()
    assert seen
    assert not any(seen)
    assert after == enabled
