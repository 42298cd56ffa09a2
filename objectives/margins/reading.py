"""Arrays that compiled code only reads, all of one kind."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def to_read(values: Array) -> Array:
    """Return values in C order that nobody may write: numba compiles for each order, and for what may be written, apart."""
    view = np.ascontiguousarray(values).view()
    view.flags.writeable = False
    return view
