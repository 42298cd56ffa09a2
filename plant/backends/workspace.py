"""The workspace of a kernel: numbers on the stack of the thread that flies, from the beginning of a cache line on.

Memory from Numba begins at a multiple of 32 bytes, a frame of the stack at one of 16, and only by chance at one of 64. Else
every vector of 64 bytes, workspace or spilled, lies across two cache lines: flights take some 3 % longer, from thread to
thread. LLVM aligns a whole frame for a variable in it that must begin at a line.
"""

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

CACHE_LINE = 64
"""Bytes, as many as the longest vectors have."""


def on_stack(count: int) -> Any:
    """Return the function that allocates so many float64 on the stack of its compiled caller."""

    @intrinsic
    def workspace(_: Any) -> Any:
        def build(_context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
            numbers = cgutils.alloca_once(builder, ir.ArrayType(ir.DoubleType(), count))
            numbers.align = CACHE_LINE
            return builder.bitcast(numbers, cgutils.voidptr_t)

        return types.voidptr(), build

    return workspace
