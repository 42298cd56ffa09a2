"""The arithmetic of a machine: what its kernels are compiled for and what its libraries compute with.

Code for another processor contracts and reassociates in another way and may differ in the last bit, so a run keeps to one.
Numba takes the processor from the machine or from a variable: a machine can compile for a lesser one than its own.
"""

import hashlib
import json
import os
import platform
from functools import cache
from typing import Any, NamedTuple

from plant.errors import StoreError


class Processor(NamedTuple):
    """name: as LLVM calls it. features: "+avx2,-avx512f,...", all that code may use or not beyond what the name says."""

    name: str
    features: str

    @property
    def label(self) -> str:
        """Name and a digest of the features."""
        return f"{self.name}-{_digest(self.features)}"


class Arithmetic(NamedTuple):
    """processor: that kernels are compiled for. libraries: loops that NumPy chose and the C library, which draws rest on."""

    processor: Processor
    libraries: str

    @property
    def label(self) -> str:
        """One line that names it."""
        return f"{self.processor.label}, {self.libraries}"


def arithmetic() -> Arithmetic:
    """Return the arithmetic of this process: processes of one arithmetic agree to the bit."""
    return Arithmetic(compiled_for(), f"numpy {numpy_simd()}, {libc() or 'another libc'}")


def compute_as(recorded: Arithmetic) -> None:
    """Have this process compute with an arithmetic; StoreError says why it cannot."""
    compile_for(recorded.processor)
    this = arithmetic()
    if this != recorded:
        raise StoreError(f"it was drawn with {recorded.libraries}, here it would be {this.libraries}")


def compiled_for() -> Processor:
    """Return the processor that this process compiles for: NUMBA_CPU_NAME and NUMBA_CPU_FEATURES, by default this one."""
    from numba.core import config

    this = this_processor()
    name, features = config.CPU_NAME, config.CPU_FEATURES  # pyright: ignore[reportAttributeAccessIssue]
    return Processor(name or this.name, this.features if features is None else features)


@cache
def this_processor() -> Processor:
    """Return the processor of this machine."""
    from llvmlite import binding
    from numba.core.codegen import get_host_cpu_features

    return Processor(binding.get_host_cpu_name(), get_host_cpu_features())


# Features that the names of the levels of x86-64 stand for, each beyond the one before.
_LEVELS = {
    "generic": "",
    "x86-64": "",
    "x86-64-v2": "+cx16,+popcnt,+sahf,+sse3,+sse4.1,+sse4.2,+ssse3",
    "x86-64-v3": "+avx,+avx2,+bmi,+bmi2,+f16c,+fma,+lzcnt,+movbe,+xsave",
    "x86-64-v4": "+avx512bw,+avx512cd,+avx512dq,+avx512f,+avx512vl",
}


def _of_name(name: str) -> set[str] | None:
    """Return the features that a processor's name represents; None where that is not known here."""
    if name == this_processor().name:
        return set()
    levels = list(_LEVELS)
    if name not in levels:
        return None
    below = levels[: levels.index(name) + 1]
    return set(",".join(_LEVELS[level] for level in below).split(",")) - {""}


def missing_features(wanted: Processor) -> list[str]:
    """Return the features of a processor that this one lacks; its name implies features that it does not list."""
    this = this_processor()
    has, required = set(this.features.split(",")), set(wanted.features.split(",")) - {""}
    named, listed = _of_name(wanted.name), {entry[1:] for entry in required}
    required |= {entry for entry in named or () if entry[1:] not in listed}
    lacking = sorted(entry[1:] for entry in required - has if entry.startswith("+"))
    all_listed = {entry[1:] for entry in has} <= listed
    return lacking if lacking or all_listed or named is not None else [f"all of {wanted.name}"]


def compile_for(wanted: Processor) -> None:
    """Have this process and those it starts compile for a processor; StoreError where this machine cannot run that code.

    It must be asked before anything is compiled.
    """
    from numba.core import config
    from numba.core.registry import cpu_target
    from numba.core.runtime.nrt import rtsys

    if wanted == compiled_for():
        return
    lacking = missing_features(wanted)
    if lacking:
        raise StoreError(f"code for {wanted.name} does not run on this processor, which lacks {', '.join(lacking)}")
    # Numba's runtime is the first that a process compiles.
    if rtsys._init:  # pyright: ignore[reportPrivateUsage]
        raise StoreError(
            f"this process compiles for {compiled_for().label} already and cannot go over to {wanted.label}; use a new process"
        )
    config.CPU_NAME, config.CPU_FEATURES = wanted  # pyright: ignore[reportAttributeAccessIssue]
    os.environ["NUMBA_CPU_NAME"], os.environ["NUMBA_CPU_FEATURES"] = wanted
    # A function that waits to be compiled has made the compiler already.
    context: Any = cpu_target.target_context
    context.init()


@cache
def numpy_simd() -> str:
    """Return NumPy's highest instruction set in use, and a digest of all."""
    import numpy as np

    extensions = np.show_config(mode="dicts")["SIMD Extensions"]  # pyright: ignore[reportOptionalSubscript]
    names = [*extensions.get("baseline", []), *extensions.get("found", [])]
    return f"{names[-1] if names else 'none'}-{_digest(json.dumps(sorted(names)))}"


@cache
def libc() -> str:
    """Return name and version of the C library: its logarithms and sines decide bits."""
    return " ".join(platform.libc_ver())


def _digest(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=4).hexdigest()
