"""What of a machine decides the bits of a flight: versions, sources, and the instructions that its compilers use."""

import hashlib
import json
import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from objectives.memory import model_key
from tuner.store.environment import simd

Report = dict[str, str]
PACKAGES = ("holdfast", "numpy", "numba", "llvmlite", "scipy")


@cache
def machine_report() -> Report:
    """Return what decides the bits here, by name.

    sources: `objectives.memory.model_key`; libc: draws take logarithms from it; target: processor and features that LLVM
    compiles for (NUMBA_CPU_NAME and NUMBA_CPU_FEATURES change them), numpy-simd: features that NumPy chose its loops by, both
    as name and digest: code for other features may contract and reassociate in another way, and differ in the last bit.
    """
    return {
        "python": platform.python_version(),
        **{name: _version(name) for name in PACKAGES},
        "sources": model_key(),
        "libc": " ".join(platform.libc_ver()),
        "target": _target(),
        "numpy-simd": _numpy_simd(),
        "simd": _simd(),
    }


def differences(ours: Report, workers: Mapping[str, Report]) -> list[str]:
    """Return a line for every name in which a worker's report differs: worker, name, theirs, ours."""
    return [
        f"{worker}: {name} {theirs.get(name, 'unknown')} there, {mine} here"
        for worker, theirs in sorted(workers.items())
        for name, mine in ours.items()
        if theirs.get(name) != mine
    ]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _target() -> str:
    from llvmlite import binding
    from numba import config

    name = config.CPU_NAME or binding.get_host_cpu_name()  # pyright: ignore[reportAttributeAccessIssue]
    features = config.CPU_FEATURES  # pyright: ignore[reportAttributeAccessIssue]
    return f"{name}/{_digest(binding.get_host_cpu_features().flatten() if features is None else features)}"


def _simd() -> str:
    from numba import config

    told = config.CPU_NAME  # pyright: ignore[reportAttributeAccessIssue]
    return f"as {told} has" if told else simd()


def _numpy_simd() -> str:
    import numpy as np

    found = np.show_config(mode="dicts")["SIMD Extensions"]  # pyright: ignore[reportOptionalSubscript]
    names = [*found.get("baseline", []), *found.get("found", [])]
    return f"{names[-1] if names else 'none'}/{_digest(json.dumps(sorted(names)))}"


def _digest(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=4).hexdigest()
