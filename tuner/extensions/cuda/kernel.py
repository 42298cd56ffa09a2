"""The cuda backend: one thread of a graphics card flies one flight, in double or in single precision.

The kernel is generated from the closed loop like that of the lanes (`plant.backends.lanes`); model functions become device
functions, all inlined. Threads of a warp fly neighbouring scenarios of one candidate: wind and noise have the scenario as
their last axis and are read side by side, a candidate's constants are read by all of them at once. Those constants are worked
out before the launch, in double precision. Values common to all flights (nominal vehicle, targets, limits) are arguments of the
kernel, which lie in the constant bank and take no registers. Absent inputs (gusts of rotation, injections, noise) are zeros that
the compiler sees.

Fast-math flags are NVVM's own: multiply-adds are contracted; in single precision subnormals are zero, and division and square
root are approximate, to 2 units in the last place. LLVM's nnan and ninf are not set, so the test for a diverged flight stays.
"""

import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import numpy as np

from plant import primitives, records
from plant.backends import branch_free, vector_math
from plant.backends.cache import load_kernel
from plant.backends.identity import identity
from plant.backends.lane_layout import result_rows
from plant.backends.lanes import body_setter, storer
from plant.backends.rebind import Rebinder, Wrap
from plant.loop import ClosedLoop
from plant.records import build_source, paths, size

BLOCK = 128
"""Threads of a block."""
BLOCKS: Mapping[str, int] = {"float32": 2, "float64": 2}
"""Blocks that shall fit a multiprocessor at once: 65536 registers are 255 for each of 2 x 128 threads, 168 for 3 x 128.

On an H200 (hybrid under ladrc, 262,144 flights of 10 s) 2 blocks fly 1.64e10 steps/s in single precision, 3 fly 1.45e10 and 4
fly 1.22e10, for what the threads' memory costs; in double precision 2.96e9, 2.61e9 and 2.37e9.
"""
REALS: Mapping[str, type[np.floating]] = {"float32": np.float32, "float64": np.float64}


class CudaRebinder(Rebinder):
    """Rebinds model functions to one precision, float32 or float64: every number that is written in them takes it.

    Numba takes a literal for a double and promotes whatever meets it, so one `0.5 * h` would turn a step into double precision.
    """

    def __init__(self, names: dict[str, Any], wrap: Wrap, real: type[np.floating]) -> None:
        super().__init__(names, wrap)
        self._real = real

    def _rebound(self, function: FunctionType) -> FunctionType:
        rebound = super()._rebound(function)
        rebound.__code__ = self._with_numbers(rebound.__code__)
        return rebound

    def _with_numbers(self, code: CodeType) -> CodeType:
        return code.replace(co_consts=tuple(self._number(value) for value in code.co_consts))

    def _translate(self, name: str, value: Any) -> Any:
        return self._number(super()._translate(name, value))

    def _number(self, value: Any) -> Any:
        return self._real(value) if isinstance(value, float) and self._real is not np.float64 else value


def simulated() -> bool:
    """Return True if Numba's simulator replaces the card (NUMBA_ENABLE_CUDASIM=1)."""
    from numba import config

    return bool(config.ENABLE_CUDASIM)  # pyright: ignore[reportAttributeAccessIssue]


def compiler() -> str:
    """Return name and version of what compiles kernels; the simulator does without numba-cuda."""
    return f"numba-cuda {version('numba-cuda')}" if find_spec("numba_cuda") else f"numba {version('numba')}"


def _inline(function: Callable[..., Any]) -> Any:
    """Return a device function; the simulator calls the plain one, without its slow wrapper."""
    from numba import cuda

    if simulated():
        return function
    return cuda.jit(device=True, forceinline=True, fastmath=True)(function)


def _kernel(blocks: int) -> Callable[..., Any]:
    """Return the decorator of kernels; without link-time optimisation, whose presence would decide bits."""
    from numba import cuda

    if simulated():
        return cuda.jit
    return cuda.jit(launch_bounds=(BLOCK, blocks), fastmath=True, lto=False)


def _cache_class() -> Any:
    """Return the class of numba-cuda's caches; the simulator compiles nothing that could be kept."""
    if simulated():
        return False
    from numba.cuda.dispatcher import CUDACache

    return CUDACache


def _names(real: type[np.floating]) -> dict[str, Any]:
    zero, one = real(0.0), real(1.0)

    def sign(a: Any) -> Any:
        return (one if a > zero else zero) - (one if a < zero else zero)

    functions = (*branch_free.FUNCTIONS, sign)
    names: dict[str, Any] = {function.__name__: _inline(function) for function in functions}
    # On the card math.floor gives a number of the same precision; in the simulator it is Python's, which refuses a NaN.
    floor = np.floor if simulated() else math.floor
    names |= {"sqrt": math.sqrt, "floor": floor, "exp": math.exp, "sin": math.sin, "cos": math.cos, "atan2": math.atan2}
    names |= {"log": math.log, "tan": math.tan, "tanh": math.tanh}
    inner = CudaRebinder(names, _inline, real)
    return names | {"asin": inner(vector_math.asin), "hypot": inner(primitives.hypot)}


RUN = """
@kernel
def run(constants_rows, nominal, dynamics_rows, starts, disturbances, noises, references, targets, limits, h, plant_step,
        substeps, out):
    i = cuda.grid(1)
    if i >= out.shape[0]:
        return
    scenario = i % dynamics_rows.shape[1]
    candidate = i // dynamics_rows.shape[1]
    dynamics = load_dynamics(dynamics_rows, scenario)
    reference = load_reference(references, 0)
    body = place(load_body(starts, scenario), reference)
    constants = load_constants(constants_rows, candidate)
    flight = start(body, constants, nominal, reference, load_noise(noises, 0, scenario), targets, dynamics)
    for k in range(references.shape[0]):
        reference = load_reference(references, k)
        disturbance = load_disturbance(disturbances, k, scenario)
        flight = decide(flight, constants, nominal, reference, load_noise(noises, k, scenario), targets, limits,
                        real(k) * h, h)
        body = flight.body
        for j in range(substeps):
            body = advance(body, flight.speed, disturbance, dynamics, plant_step)
        flight = with_body(flight, body)
    store_result(out, i, flight)
"""


def kernel_source(loop: ClosedLoop, wind_rows: int, noise_rows: int, names: dict[str, Any]) -> str:
    """Return the source of the kernel module of a loop; collects the record types it names."""
    flight, kinds = loop.Flight, loop.records
    parts = [
        _loader(loop.Constants, "constants", "a, i", "a[i, {}]", names),
        _loader(kinds.Reference, "reference", "a, i", "a[i, {}]", names),
        _loader(kinds.Dynamics, "dynamics", "a, i", "a[{}, i]", names),
        _loader(loop.Body, "body", "a, i", "a[{}, i]", names),
        _loader(kinds.Disturbance, "disturbance", "a, k, i", "a[k, {}, i]", names, wind_rows),
        _loader(kinds.Noise, "noise", "a, k, i", "a[k, {}, i]", names, noise_rows),
        body_setter(flight, names),
        storer(paths(flight)[result_rows(loop)], "store_result", "a, i", "a[i, {}]"),
        RUN,
    ]
    return "\n".join(parts)


def _loader(kind: Any, name: str, arguments: str, entry: str, names: dict[str, Any], rows: int | None = None) -> str:
    """Return the source of a function from array to record; leaves from `rows` on are zero."""
    count = size(kind) if rows is None else rows
    leaves = [entry.format(i) if i < count else "ZERO" for i in range(size(kind))]
    return f"@inline\ndef load_{name}({arguments}):\n    return {build_source(kind, leaves, names)}\n"


def kernel_names(loop: ClosedLoop, precision: str) -> tuple[dict[str, Any], set[Path]]:
    """Return the globals of a loop's kernel modules, and their source files."""
    from numba import cuda

    real = REALS[precision]
    bind = CudaRebinder(_names(real), _inline, real)
    names: dict[str, Any] = {
        "cuda": cuda,
        "inline": _inline,
        "real": real,
        "ZERO": real(0.0),
        "start": bind(loop.start),
        "decide": bind(loop.decide),
        "advance": bind(loop.advance),
        "place": bind(loop.place),
    }
    kernel_sources = {
        Path(str(part.__file__)) for part in (records, primitives, branch_free, vector_math, sys.modules[__name__])
    }
    return names, bind.sources | kernel_sources | loop.sources


@dataclass(frozen=True)
class CudaKernel:
    """A kernel: run[blocks, BLOCK](...) launches it; cached says whether an earlier process compiled it."""

    run: Any
    cached: bool


def kernel_of(
    loop: ClosedLoop, wind_rows: int, noise_rows: int, precision: str, blocks: int | None = None
) -> CudaKernel:
    """Return the kernel of a loop; its first launch compiles it.

    Args:
        loop: Closed loop.
        wind_rows: Rows of air that its scenarios have.
        noise_rows: Rows of noise.
        precision: float64 or float32.
        blocks: Blocks that shall fit a multiprocessor at once, see `BLOCKS`.
    """
    names, sources = kernel_names(loop, precision)
    bound = blocks or BLOCKS[precision]
    header = f"# {precision}, {compiler()}, blocks of {BLOCK}, {bound} at once\n"
    source = header + kernel_source(loop, wind_rows, noise_rows, names)
    name = f"cuda_{precision}_{loop.name}"
    module, cached = load_kernel(
        name, source, names | {"kernel": _kernel(bound)}, sources, identity(loop), _cache_class()
    )
    return CudaKernel(module.run, cached)
