"""The lanes backend: scenarios side by side in SIMD lanes, candidates on threads. Every study runs on it.

A block holds LANES scenarios of one candidate. Its whole state lives in one workspace (row, lane); the innermost loop runs over
lanes and is turned into vector code by LLVM. Wind, noise and dynamics are copied into the workspace too: read from their own
arrays they exceed the compiler's run-time alias checks and the loop stays scalar, six times slower. It lies on the stack
(`plant.backends.workspace`).

A quadrotor's loop stands there twice: if the air of a batch is wind alone, its other nine rows are zeros that the compiler
sees. That makes a flight 7 % faster and the compilation 1 s of 15 longer. The two loops may round differently (1e-12 after
10 s). Which of them flies is a scenario's own: whether it has gust rates or injections does not hang on the batch.

The composed kernel is compiled once and kept (`plant.backends.cache`).
"""

import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any
from weakref import WeakKeyDictionary

import numba
import numpy as np
from numba.np.numpy_support import carray

from plant import primitives, records
from plant.backends import branch_free, compiling, vector_math, workspace
from plant.backends.cache import is_compiled, load_kernel
from plant.backends.compiling import inliner, kernel
from plant.backends.identity import identity
from plant.backends.lane_layout import LANES, layout, result_rows
from plant.backends.rebind import Rebinder
from plant.loop import ClosedLoop
from plant.records import build_source, paths, rows, size

# Never nnan or ninf: they would delete the test for a diverged flight.
FAST_MATH = {"contract", "reassoc", "arcp", "nsz", "afn"}


OPTIONS: dict[str, Any] = {"fastmath": FAST_MATH, "error_model": "numpy"}
_inline = inliner(OPTIONS)


def _names() -> dict[str, Any]:
    def sign(a: float) -> float:
        return (1.0 if a > 0.0 else 0.0) - (1.0 if a < 0.0 else 0.0)

    functions = (*branch_free.FUNCTIONS, sign)
    names: dict[str, Any] = {function.__name__: _inline(function) for function in functions}
    names |= {"sqrt": math.sqrt, "floor": np.floor, "exp": math.exp, "sin": math.sin, "cos": math.cos}
    names |= {"log": math.log, "tan": math.tan, "tanh": math.tanh}
    inner = Rebinder(names, _inline)
    names |= {"atan2": inner(vector_math.atan2), "asin": inner(vector_math.asin), "hypot": inner(primitives.hypot)}
    return names


def rebinder() -> Rebinder:
    """Return a rebinder to inlined, compiled functions; only compiled code may call them (see `compiled`)."""
    return Rebinder(_names(), _inline)


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return one model function compiled with the lanes' flags, for calls from Python."""
    inner = rebinder()(function)

    def call(*arguments: Any) -> Any:
        return inner(*arguments)

    return kernel(OPTIONS)(call)


def loader(kind: Any, name: str, expression: str, offset: int, names: dict[str, Any], given: int | None = None) -> str:
    """Return the source of a function from rows of a lane, or a vector, to a record.

    given: number of leaves that are read, by default all; the others are zeros that the compiler sees.
    """
    read = size(kind) if given is None else given
    leaves = [expression.format(offset + i) if i < read else "0.0" for i in range(size(kind))]
    return f"@inline\ndef {name}(a, l):\n    return {build_source(kind, leaves, names)}\n"


def storer(leaves: Sequence[str], name: str, arguments: str, expression: str, offset: int = 0) -> str:
    """Return the source that stores a record: its leaves at these paths, from row offset on."""
    lines = [f"    {expression.format(offset + i)} = s.{path}" for i, path in enumerate(leaves)]
    return f"@inline\ndef {name}({arguments}, s):\n" + "\n".join(lines) + "\n"


def body_setter(flight: Any, names: dict[str, Any]) -> str:
    """Return the source that puts a body into a flight."""
    leaves = [f"body.{path[5:]}" if path.startswith("body.") else f"s.{path}" for path in paths(flight)]
    return f"@inline\ndef with_body(s, body):\n    return {build_source(flight, leaves, names)}\n"


LANE, ENTRY = "a[{}, l]", "a[{}]"

# Copies are loops: an assignment of a slice is an array walked stride by stride, and compiles its error message besides.
RUN = """
@inline
def put(a, row, part):
    for r in range(part.shape[0]):
        for l in range(LANES):
            a[row + r, l] = part[r, l]


@kernel
def run(gains, nominal_row, dynamicss, starts, disturbances, noises, references, targets_row, limits_row, h, plant_step,
        substeps, out, traced, trace, every):
    nominal = load_nominal(nominal_row, 0)
    targets = load_targets(targets_row, 0)
    limits = load_limits(limits_row, 0)
    n_disturbance = disturbances.shape[2]
    for i in range(gains.shape[0] * dynamicss.shape[0]):
        candidate, block = i // dynamicss.shape[0], i % dynamicss.shape[0]
        constants = prepare(load_gains(gains[candidate], 0), h)
        reference = load_reference(references[0], 0)
        a = carray(workspace(), (TOTAL, LANES), np.float64)
        for r in range(TOTAL):
            for l in range(LANES):
                a[r, l] = 0.0
        put(a, DYNAMICS, dynamicss[block])
        put(a, NOISE, noises[block, 0])
        put(a, BODY, starts[block])
        for l in range(LANES):
            body = place(load_body(a, l), reference)
            store_flight(a, l, start(body, constants, nominal, reference, load_noise(a, l), targets,
                                     load_dynamics(a, l)))
        for k in range(references.shape[0]):
            put(a, DISTURBANCE, disturbances[block, k])
            put(a, NOISE, noises[block, k])
            reference = load_reference(references[k], 0)
            time = k * h
            for l in range(LANES):
                store_flight(a, l, decide(load_flight(a, l), constants, nominal, reference, load_noise(a, l), targets,
                                          limits, time, h))
            if every > 0 and k % every == 0:
                for i in range(traced.shape[0]):
                    for l in range(LANES):
                        trace[candidate, block, k // every, i, l] = a[traced[i], l]
ADVANCE
        for r in range(N_RESULT):
            for l in range(LANES):
                out[candidate, block, r, l] = a[RESULT + r, l]
"""

ADVANCE_ALL = """
            for j in range(substeps):
                for l in range(LANES):
                    store_body(a, l, advance(load_body(a, l), load_speed(a, l), load_disturbance(a, l),
                                             load_dynamics(a, l), plant_step))
""".strip("\n")

ADVANCE_WIND_OR_ALL = """
            if n_disturbance <= N_WIND:
                for j in range(substeps):
                    for l in range(LANES):
                        store_body(a, l, advance(load_body(a, l), load_speed(a, l), load_wind(a, l),
                                                 load_dynamics(a, l), plant_step))
            else:
                for j in range(substeps):
                    for l in range(LANES):
                        store_body(a, l, advance(load_body(a, l), load_speed(a, l), load_disturbance(a, l),
                                                 load_dynamics(a, l), plant_step))
""".strip("\n")


def kernel_source(loop: ClosedLoop, names: dict[str, Any]) -> str:
    """Return the source of the kernel module of a loop; collects the record types it names."""
    place_of = layout(loop)
    flight, kinds = loop.Flight, loop.records
    body, speed = rows(flight, "body"), rows(flight, "speed")
    types = flight.__annotations__
    parts = [
        loader(flight, "load_flight", LANE, place_of.flight, names),
        storer(paths(flight), "store_flight", "a, l", LANE, place_of.flight),
        loader(types["body"], "load_body", LANE, body.start, names),
        storer(paths(types["body"]), "store_body", "a, l", LANE, body.start),
        loader(types["speed"], "load_speed", LANE, speed.start, names),
        loader(kinds.Dynamics, "load_dynamics", LANE, place_of.dynamics, names),
        loader(kinds.Disturbance, "load_disturbance", LANE, place_of.disturbance, names),
        loader(kinds.Disturbance, "load_wind", LANE, place_of.disturbance, names, kinds.n_wind_leaves),
        loader(kinds.Noise, "load_noise", LANE, place_of.noise, names),
        vector_loaders(loop, names),
    ]
    result = result_rows(loop)
    constants = {
        "TOTAL": place_of.total,
        "DYNAMICS": place_of.dynamics,
        "NOISE": place_of.noise,
        "DISTURBANCE": place_of.disturbance,
        "RESULT": result.start,
        "N_RESULT": result.stop - result.start,
        "N_WIND": kinds.n_wind_leaves,
        "LANES": LANES,
        "BODY": body.start,
    }
    header = "\n".join(f"{name} = {value}" for name, value in constants.items())
    is_all_wind = kinds.n_wind_leaves == size(kinds.Disturbance)
    return "\n".join([header, *parts, RUN.replace("ADVANCE", ADVANCE_ALL if is_all_wind else ADVANCE_WIND_OR_ALL)])


def vector_loaders(loop: ClosedLoop, names: dict[str, Any]) -> str:
    """Return the sources of the functions from vectors to the records that lanes share."""
    kinds = loop.records
    shared = {
        "gains": kinds.Gains,
        "nominal": kinds.Nominal,
        "reference": kinds.Reference,
        "targets": kinds.Targets,
        "limits": kinds.Limits,
    }
    return "\n".join(loader(kind, f"load_{name}", ENTRY, 0, names) for name, kind in shared.items())


@dataclass(frozen=True)
class Kernel:
    """A kernel: run is its entry, cached says whether an earlier process compiled it (else the first call takes long)."""

    run: Callable[..., None]
    cached: bool


def kernel_names(loop: ClosedLoop) -> tuple[dict[str, Any], set[Path]]:
    """Return the globals of a loop's kernel modules, and their source files."""
    bind = rebinder()
    names: dict[str, Any] = {
        "np": np,
        "jit": numba.njit,
        "kernel": kernel(OPTIONS),
        "inline": _inline,
        "FAST_MATH": FAST_MATH,
        "prepare": bind(loop.prepare),
        "start": bind(loop.start),
        "decide": bind(loop.decide),
        "advance": bind(loop.advance),
        "place": bind(loop.place),
    }
    kernel_sources = {
        Path(str(part.__file__))
        for part in (records, primitives, branch_free, compiling, vector_math, sys.modules[__name__])
    }
    return names, bind.sources | kernel_sources | loop.sources


_MODULES: WeakKeyDictionary[ClosedLoop, ModuleType] = WeakKeyDictionary()
"""Modules of kernels by their loops: a run has several problems with one loop, and each lookup on disk takes 12 ms."""


def kernel_of(loop: ClosedLoop) -> Kernel:
    """Return the kernel of a loop: from the cache, or compiled by its first call."""
    module = _MODULES.get(loop)
    if module is None:
        module = _MODULES[loop] = _module_of(loop)
    return Kernel(module.run, is_compiled(module.run))


def _module_of(loop: ClosedLoop) -> ModuleType:
    names, sources = kernel_names(loop)
    names |= {"carray": carray, "workspace": workspace.on_stack(layout(loop).total * LANES)}
    source = kernel_source(loop, names)
    return load_kernel(loop.name, source, names, sources | {Path(workspace.__file__)}, identity(loop))[0]
