"""The shared library inside an FMU, compiled by this machine's gcc where it has one that makes code for x86-64 Linux."""

import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from plant.errors import InputError

PLATFORM = "linux64"
# Multiply and add are not contracted and nothing is reordered: results are the bits of the C code on any IEEE machine.
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fPIC", "-shared", "-fvisibility=hidden")
# No build id, no symbols, no machine's own start files: the same sources and gcc give the same bytes.
LINKING = ("-s", "-Wl,--build-id=none", "-lm")


def compiler() -> str | None:
    """Return the gcc that makes binaries for this FMU, or None."""
    gcc = shutil.which("gcc")
    if gcc is None:
        return None
    machine = subprocess.run([gcc, "-dumpmachine"], capture_output=True, text=True).stdout
    return gcc if machine.startswith("x86_64") and "linux" in machine else None


def shared_library(sources: Mapping[str, str], units: Sequence[str], gcc: str) -> bytes:
    """Compile sources (name -> text) and return the library; units: the files to compile."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        for name, text in sources.items():
            (folder / name).write_text(text, encoding="utf-8")
        done = subprocess.run(
            [gcc, *FLAGS, *units, "-o", "library.so", *LINKING], cwd=folder, capture_output=True, text=True
        )
        if done.returncode != 0:
            raise InputError(f"gcc could not compile the FMU: {done.stderr.strip()[-2000:]}", key="--to")
        return (folder / "library.so").read_bytes()
