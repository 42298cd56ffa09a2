"""Numba's options for kernels, for what they inline, and their arrays."""

import gc
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numpy.typing import NDArray

Array = NDArray[np.float64]


NUMBERS = "numba7cpython7numbers"
"""Mangled name of numba's module of arithmetic."""


class _KernelLibrary(JITCodeLibrary):
    """Code of a kernel: numba's arithmetic of complex numbers is inlined too, however large its caller is.

    With the longer code of Python 3.14 LLVM left their product a function of its own, which another kernel has too.
    """

    def _optimize_final_module(self) -> None:
        for part in self._final_module.functions:
            if NUMBERS in part.name and not part.is_declaration:
                part.add_function_attribute("alwaysinline")
        super()._optimize_final_module()


class KernelCompiler(Compiler):
    """Numba's compiler, with Python's garbage collector at rest.

    The collector walks through all trees of the functions in work, again and again: 11 % of the time, and finds nothing.
    """

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a function."""
        if self.state.library is None:
            self.state.library = _KernelLibrary(self.state.targetctx.codegen(), func.__qualname__)
            # As numba does with a library of its own; else nothing is kept.
            self.state.library.enable_object_caching()
        if not gc.isenabled():
            return super().compile_extra(func)
        gc.disable()
        try:
            return super().compile_extra(func)
        finally:
            gc.enable()


class _InlinedLibrary(JITCodeLibrary):
    """Code that is optimised for its callers.

    It is never translated to machine code, which no caller runs and which took a sixth of the time.
    """

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


def _finalize(library: _InlinedLibrary, *_: Any) -> Any:
    """Finish a library, in place of numba's `get_executable`; the function in it raises TypeError if Python calls it."""
    library.finalize()
    # Numba tells functions apart by this object, which must be a built-in function and gets a tuple: this one takes only text.
    return object().__format__


class _InlinedCompiler(KernelCompiler):
    """Numba's compiler for functions that are inlined into all their callers."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a function into a library that only its callers read."""
        context = self.state.targetctx
        self.state.library = _InlinedLibrary(context.codegen(), func.__qualname__)
        # The context is this compilation's own copy.
        context.get_executable = _finalize
        return super().compile_extra(func)


def kernel(options: dict[str, Any]) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles functions for calls from Python.

    They give Python's lock away.
    """
    return numba.njit(**options, nogil=True, pipeline_class=KernelCompiler)


def inliner(options: dict[str, Any], allocates: bool = False) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that has numba inline functions into their callers only.

    allocates: whether the functions make arrays. Others need no counts of references, and records of 300 numbers are searched
    for something to be counted at every use.
    """
    # Wrappers for calls from Python take longer to compile than the functions.
    inlined: dict[str, Any] = {
        "forceinline": True,
        "no_cpython_wrapper": True,
        "no_cfunc_wrapper": True,
        "_nrt": allocates,
    }
    return numba.njit(**options, **inlined, pipeline_class=_InlinedCompiler)


def read_only(values: Array) -> Array:
    """Return read-only values in C order: numba compiles each order, and writable values, apart."""
    view = np.ascontiguousarray(values).view()
    view.flags.writeable = False
    return view
