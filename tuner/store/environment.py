"""What a result was computed with: versions, machine, command, commit."""

import json
import os
import platform
import shlex
import subprocess
import sys
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from plant.backends.processor import arithmetic
from plant.input_files import read_input_text

PACKAGES = ("holdfast", "numpy", "scipy", "numba", "llvmlite", "pymoo", "cmaes", "pandas", "pyarrow")


def environment(threads: int) -> dict[str, str | int | None]:
    """Return versions, platform, processor, threads, start time (UTC), command line and commit."""
    return {
        **{name: _version(name) for name in PACKAGES},
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cpu": processor(),
        "simd": simd(),
        "target": arithmetic().label,
        "threads": threads,
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]),
        "commit": _commit(),
    }


def with_session(file: Path, now: dict[str, str | int | None]) -> dict[str, Any]:
    """Return the environment of a run's first session, read from its file, with this session among "resumed"; or this one."""
    try:
        first = json.loads(read_input_text(file))
        sessions = first.pop("resumed", [])
    except (OSError, ValueError, AttributeError):
        return {**now}
    return {**first, "resumed": [*sessions, now]}


def processor() -> str:
    """Return the processor's name as the system tells it."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(errors="replace").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def simd() -> str:
    """Return the widest vector instruction set that the compiler uses here: "avx512", "avx2", "neon" or "sse2"."""
    from llvmlite import binding

    features = binding.get_host_cpu_features()
    if features.get("avx512f"):
        return "avx512"
    if features.get("avx2"):
        return "avx2"
    return "neon" if features.get("neon") else "sse2"


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _commit() -> str | None:
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return None
    try:
        asked = subprocess.run(
            ["git", "describe", "--always", "--dirty"], cwd=root, capture_output=True, text=True, timeout=5, check=True,
            env=os.environ | {"GIT_OPTIONAL_LOCKS": "0"},
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return None
    return asked.stdout.strip()
