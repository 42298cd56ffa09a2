"""Properties of a machine that decide the bits of a flight: versions, sources, and the instructions that its compilers use."""

import platform
from collections.abc import Mapping

from objectives.memory import model_key
from plant.backends.processor import Processor, compile_for, compiled_for, libc, numpy_simd
from tuner.text.version import version

Report = dict[str, str]
PACKAGES = ("gainproof", "numpy", "numba", "llvmlite", "scipy")


def machine_report() -> Report:
    """Return the properties of this machine that decide the bits, by name.

    sources: `objectives.memory.model_key`; libc: draws take logarithms from it; target: processor and features that LLVM
    compiles for (NUMBA_CPU_NAME and NUMBA_CPU_FEATURES change them), numpy-simd: features that NumPy chose its loops by, both
    as name and digest: code for other features may contract and reassociate in another way, and differ in the last bit.
    """
    return {
        "python": platform.python_version(),
        **{name: version(name) for name in PACKAGES},
        "sources": model_key(),
        "libc": libc(),
        "target": compiled_for().label,
        "numpy-simd": numpy_simd(),
    }


def report_for(target: Processor) -> Report:
    """Go over to compiling for a processor and return the report; StoreError where that cannot be done here."""
    compile_for(target)
    return machine_report()


def differences(ours: Report, workers: Mapping[str, Report]) -> list[str]:
    """Return a line for every name in which a worker's report differs: worker, name, theirs, ours."""
    return [
        f"{worker}: {name} {theirs.get(name, 'unknown')} there, {mine} here"
        for worker, theirs in sorted(workers.items())
        for name, mine in ours.items()
        if theirs.get(name) != mine
    ]
