"""Functions that numba compiles beside the kernels: their inlined parts, and the one kind of array that they read."""

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numpy.typing import NDArray

Array = NDArray[np.float64]


class _InlinedLibrary(JITCodeLibrary):
    """The code of a function that is only inlined: optimised, but never translated to machine code, which nobody would run."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


def _finalize(library: _InlinedLibrary, *_: Any) -> Any:
    library.finalize()
    return object().__sizeof__


class InlinedCompiler(Compiler):
    """Numba's compiler for functions that are only inlined."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile a function into a library that only callers read."""
        context = self.state.targetctx
        self.state.library = _InlinedLibrary(context.codegen(), func.__qualname__)
        context.get_executable = _finalize
        return super().compile_extra(func)


def inliner(options: dict[str, Any], **more) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that has numba inline functions into their callers only."""
    # Wrappers for calls from Python take longer to compile than the functions.
    inlined: dict[str, Any] = {"forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    return numba.njit(**options, **inlined, **more, pipeline_class=InlinedCompiler)


def read_only(values: Array) -> Array:
    """Return values in C order that nobody may write: numba compiles for each order, and for what may be written, apart."""
    view = np.ascontiguousarray(values).view()
    view.flags.writeable = False
    return view
