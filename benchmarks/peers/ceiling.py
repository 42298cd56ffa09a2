"""The loop by hand in C, `ceiling.c`, compiled here: clang where there is one, for gcc 12 leaves the control step scalar."""

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks.course import LIMITS, SUBSTEPS, TIMING, Course, split
from benchmarks.peers.contestant import Work
from plant.backends.flyer import to_lanes
from plant.quadrotor.nominal import Nominal
from plant.records import index
from plant.threads import available_threads

SOURCE = Path(__file__).with_name("ceiling.c")
FLAGS = "-O3 -march=native -ffast-math -fno-finite-math-only -fopenmp-simd -fPIC".split()
ROWS = 72
POINTER = ctypes.POINTER(ctypes.c_double)


def compiler() -> str | None:
    """Return the compiler that does best here."""
    return shutil.which("clang") or shutil.which("gcc")


def build(scratch: Path, *defines: str) -> Callable[..., None]:
    """Compile and load `run`."""
    chosen = compiler()
    if chosen is None:
        raise RuntimeError("no C compiler found (clang or gcc)")
    file = scratch / f"ceiling{''.join(defines)}.so"
    loose = file.with_suffix(".o")
    # Linked apart: with -ffast-math a library takes numbers below 2e-308 for 0 in the whole process that loads it.
    for command in ([*FLAGS, *defines, "-c", SOURCE, "-o", loose], ["-shared", loose, "-o", file, "-lm"]):
        subprocess.run([chosen, *command], check=True, capture_output=True)
    run = ctypes.CDLL(str(file)).run
    run.argtypes = [POINTER] * 8 + [ctypes.c_double] * 2 + [ctypes.c_int] * 4 + [POINTER]
    run.restype = None
    return run


def known(nominal: np.ndarray) -> np.ndarray:
    """Return a flat `Nominal` as that of `ceiling.c` begins, without the numbers of a vehicle that its file may leave out.

    What follows the low-pass on yaw has no part in the course.
    """
    left_out = slice(index(Nominal, "vehicle.gravity") + 1, index(Nominal, "allocation.thrust.r1"))
    return np.delete(nominal, left_out)


def flights(
    course: Course, batch: int, periods: int, threads: int, scratch: Path, *defines: str
) -> Callable[[], np.ndarray]:
    """Return the flights of a batch: results (candidates, scenarios, rows)."""
    run = build(scratch, *defines)
    candidates, scenarios = split(batch)
    part = course.part(scenarios, periods)
    dynamics, winds, noises = (to_lanes(np.moveaxis(a, -1, 0)) for a in (part.dynamics, part.winds, part.noises))
    out = np.empty((candidates, len(dynamics), ROWS, dynamics.shape[-1]))
    gains, limits = np.tile(course.gains, (candidates, 1)), np.array(LIMITS)
    arrays = (known(course.nominal), dynamics, winds, noises, part.references, course.targets, limits)
    assert all(array.flags.c_contiguous and array.dtype == np.float64 for array in arrays)

    def fly(candidate: int) -> None:
        own, result = gains[candidate], out[candidate]
        run(_pointer(own), *map(_pointer, arrays), *TIMING, SUBSTEPS, 1, len(dynamics), periods, _pointer(result))

    def work() -> np.ndarray:
        with ThreadPoolExecutor(threads or available_threads()) as pool:
            list(pool.map(fly, range(candidates)))
        return np.moveaxis(out, -1, 2).reshape(candidates, -1, ROWS)[:, :scenarios]

    return work


def _pointer(array: np.ndarray) -> object:
    return array.ctypes.data_as(POINTER)


def prepare(course: Course, batch: int, periods: int, threads: int, scratch: Path) -> Work:
    """Compile; the same algebra as the model's."""
    return flights(course, batch, periods, threads, scratch)
