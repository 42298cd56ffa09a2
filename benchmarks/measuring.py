"""How a benchmark measures: wall and processor time of a piece of work, peak memory, what machine it was on, medians of ratios.

The machines are shared. So contestants take turns within a round, what counts is the median over rounds of the ratio within a
round, and processor time is recorded beside wall time: it does not count the time that other people's work took.
"""

import json
import os
import platform
import resource
import shlex
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any, NamedTuple

RESULTS = Path(__file__).parent / "results"


class ElapsedTimes(NamedTuple):
    """Wall and processor seconds; the latter summed over all threads of the process."""

    wall: float
    busy: float


def spent(work: Callable[[], Any]) -> ElapsedTimes:
    """Return what one call takes."""
    wall, busy = perf_counter(), process_time()
    work()
    return ElapsedTimes(perf_counter() - wall, process_time() - busy)


def peak_memory() -> float:
    """Return the largest resident memory of this process so far [MB]: VmHWM where the system tells it."""
    status = Path("/proc/self/status")
    if status.exists():
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM"):
                return int(line.split()[1]) / 1024.0
    # Linux counts in kB, macOS in bytes.
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1024.0 if sys.platform == "linux" else 2.0**20)


def ratio(above: Sequence[float], below: Sequence[float]) -> float:
    """Return the median over rounds of the quotient within a round."""
    return median(a / b for a, b in zip(above, below, strict=True))


def versions(*names: str) -> dict[str, str]:
    """Return the versions of installed packages; those that are missing are left out."""
    found = {"python": platform.python_version()}
    for name in names:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def machine() -> dict[str, Any]:
    """Return what a figure was measured on."""
    # The environments of peers, whose workers measure too, have no pydantic.
    from tuner.store.environment import processor

    return {
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "load": [round(value, 2) for value in os.getloadavg()] if hasattr(os, "getloadavg") else None,
        "platform": platform.platform(),
        "command": shlex.join(["python", "-m", _module(), *sys.argv[1:]]),
        "versions": versions("numpy", "numba", "llvmlite", "casadi"),
    }


def write_json(file: Path, document: Any) -> None:
    """Write a document for people and programs."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def _module() -> str:
    spec = getattr(sys.modules["__main__"], "__spec__", None)
    return "benchmarks" if spec is None else spec.name.removesuffix(".__main__")
