"""The environment of a result: versions, machine, command, commit."""

import os
import platform
import shlex
import subprocess
import sys
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from pydantic import AliasChoices, Field

from plant.backends.processor import arithmetic
from plant.errors import StoreError
from tuner.store.document import Document
from tuner.text.product import FORMER_NAME, NAME

PACKAGES = (NAME, "numpy", "scipy", "numba", "llvmlite", "pymoo", "cmaes", "pandas")


class Environment(Document):
    """Content of environment.json: versions of packages, machine and command of a session, null where not known.

    target: processor that kernels were compiled for, and libraries; started: time (UTC); resumed: later sessions of the same run.
    """

    gainproof: str | None = Field(default=None, validation_alias=AliasChoices(NAME, FORMER_NAME))
    numpy: str | None = None
    scipy: str | None = None
    numba: str | None = None
    llvmlite: str | None = None
    pymoo: str | None = None
    cmaes: str | None = None
    pandas: str | None = None
    # Of earlier versions, which wrote Parquet.
    pyarrow: str | None = None
    python: str | None = None
    platform: str | None = None
    cpu: str | None = None
    simd: str | None = None
    target: str | None = None
    threads: int | None = None
    started: str | None = None
    command: str | None = None
    commit: str | None = None
    resumed: list["Environment"] = []


def environment(threads: int) -> Environment:
    """Return versions, platform, processor, threads, start time (UTC), command line and commit."""
    versions = {name: _version(name) for name in PACKAGES}
    return Environment.model_validate(
        {
            **versions,
            "python": platform.python_version(),
            "platform": platform.platform(),
            "cpu": processor(),
            "simd": simd(),
            "target": arithmetic().label,
            "threads": threads,
            "started": datetime.now(UTC).isoformat(timespec="seconds"),
            "command": shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]),
            "commit": commit(),
        }
    )


def with_session(file: Path, now: Environment) -> Environment:
    """Return the environment of a run's first session, with this one added.

    It is read from its file, with the present session among "resumed"; without a file, the present one's is returned.
    """
    try:
        first = Environment.read(file)
    except StoreError:
        return now
    return first.model_copy(update={"resumed": [*first.resumed, now]})


@cache
def processor() -> str:
    """Return the processor's name as the system has it."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8", errors="replace").splitlines():
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


@cache
def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


@cache
def commit() -> str | None:
    """Return the revision of a clone, marked where files differ from it; None elsewhere.

    It is that of the first call in a process, which is nearer to the code that the process runs than a later one.
    """
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return None
    try:
        git = subprocess.run(
            ["git", "describe", "--always", "--dirty"],
            cwd=root,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=5,
            check=True,
            env=os.environ | {"GIT_OPTIONAL_LOCKS": "0"},
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return git.stdout.strip()
