"""Functions that numba compiles beside the kernels: their inlined parts, and the one kind of array that they read."""

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def inliner(options: dict[str, Any]) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that has numba inline functions into their callers only."""
    # Wrappers for calls from Python take longer to compile than the functions.
    inlined: dict[str, Any] = {"forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    return numba.njit(**options, **inlined)


def read_only(values: Array) -> Array:
    """Return values in C order that nobody may write: numba compiles for each order, and for what may be written, apart."""
    view = np.ascontiguousarray(values).view()
    view.flags.writeable = False
    return view
