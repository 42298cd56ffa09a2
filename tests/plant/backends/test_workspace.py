"""Numbers on the stack of compiled code: where they begin, and that each call has its own."""

from concurrent.futures import ThreadPoolExecutor

import numba
import numpy as np
from numba.np.numpy_support import carray

from plant.backends.workspace import CACHE_LINE, on_stack

COUNT, CALLS = 5, 20
room = on_stack(COUNT)


@numba.njit
def nested(depth, addresses, kept):
    """Write depth all over the numbers, have other calls do so, and say where the numbers begin and what is in them then."""
    numbers = carray(room(), COUNT, np.float64)
    for i in range(COUNT):
        numbers[i] = depth
    if depth > 0:
        nested(depth - 1, addresses, kept)
    addresses[depth] = numbers.ctypes.data
    for i in range(COUNT):
        kept[depth, i] = numbers[i]


def called(_):
    addresses, kept = np.zeros(CALLS, dtype=np.int64), np.zeros((CALLS, COUNT))
    nested(CALLS - 1, addresses, kept)
    return addresses, kept


def test_numbers_begin_at_a_cache_line_wherever_the_stack_stands_and_belong_to_one_call():
    with ThreadPoolExecutor(3) as pool:
        for addresses, kept in pool.map(called, range(6)):
            assert len(set(addresses.tolist())) == CALLS
            assert not np.any(addresses % CACHE_LINE)
            assert np.array_equal(kept, np.repeat(np.arange(CALLS, dtype=float)[:, None], COUNT, axis=1))
