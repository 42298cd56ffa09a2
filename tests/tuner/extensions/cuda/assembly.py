"""Compile a kernel to PTX and assemble it, without a card: what registers and local memory it takes and what is in its loops."""

import os
import re
import subprocess
from collections import Counter
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from unittest.mock import patch

import numpy as np

from plant.quadrotor.closed_loop import Limits
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.sample import Targets
from plant.records import pack, size
from tests.plant.loops import loop
from tuner.extensions.cuda.kernel import BLOCK, BLOCKS, REALS, kernel_names, kernel_source

HOMES = [os.environ.get("CUDA_HOME", ""), "/usr/local/cuda", *map(str, sorted(Path("/usr/local").glob("cuda-*")))]


@cache
def toolkit():
    """Folder of a CUDA toolkit that can compile kernels and assemble them, or None."""
    parts = ("bin/ptxas", "nvvm/libdevice")
    return next((Path(home) for home in HOMES if home and all((Path(home) / part).exists() for part in parts)), None)


@cache
def missing():
    """Why no kernel can be compiled here, or None."""
    if toolkit() is None:
        return "there is no CUDA toolkit"
    if find_spec("numba_cuda") is None:
        return "numba-cuda is not installed"
    os.environ["CUDA_HOME"] = str(toolkit())
    from numba import types
    from numba.cuda import compile_ptx  # pyright: ignore[reportPrivateImportUsage]

    def nothing(a):
        a[0] = 0

    try:
        compile_ptx(nothing, (types.float32[::1],), cc=(8, 0))
    except Exception as error:  # whatever a library says that does not find another
        return f"numba-cuda finds no compiler ({str(error).splitlines()[0]})"
    return None


class Anywhere:
    """Stands for the device that numba-cuda asks which device functions to compile for."""

    compute_capability = (8, 0)


@cache
def ptx(position, attitude, precision, wind_rows=3, noise_rows=12):
    """PTX of a kernel for compute capability 8.0, which later cards' assemblers take too."""
    from numba import typeof, types
    from numba.cuda import compile_ptx, dispatcher  # pyright: ignore[reportPrivateImportUsage]

    names, _ = kernel_names(loop(position, attitude), precision)
    source = kernel_source(loop(position, attitude), wind_rows, noise_rows, names)
    names["kernel"] = lambda function: function
    exec(source, names)
    real = REALS[precision]
    scalar = typeof(real(0))
    nominal, targets, limits = (typeof(pack(kind, [real(0)] * size(kind))) for kind in (Nominal, Targets, Limits))
    one, three = types.Array(scalar, 2, "C"), types.Array(scalar, 3, "C")
    signature = (one, nominal, one, three, three, one, targets, limits, scalar, scalar, types.int32, one)
    with patch.object(dispatcher, "get_current_device", Anywhere):
        return compile_ptx(
            names["run"],
            signature,
            cc=Anywhere.compute_capability,
            fastmath=True,
            launch_bounds=(BLOCK, BLOCKS[precision]),  # pyright: ignore[reportCallIssue]
        )[0]


@dataclass(frozen=True)
class Resources:
    """Of one thread: registers, bytes of local memory."""

    registers: int
    local: int


def assembled(text, architecture, folder):
    """Assemble PTX and return what the assembler reports."""
    file = folder / "kernel.ptx"
    file.write_text(text)
    command = [f"{toolkit()}/bin/ptxas", "-v", f"-arch={architecture}", str(file), "-o", str(folder / "kernel.cubin")]
    report = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300).stderr
    registers, local = re.search(r"Used (\d+) registers", report), re.search(r"(\d+) bytes stack frame", report)
    assert registers is not None and local is not None, report
    return Resources(int(registers[1]), int(local[1]))


def innermost(text):
    """Instructions of the loop in a kernel's PTX that holds no other and multiplies most: the plant step."""
    lines = [line.strip() for line in text.splitlines()]
    labels = {line[:-1]: i for i, line in enumerate(lines) if re.fullmatch(r"\$L\w+:", line)}
    loops = []
    for i, line in enumerate(lines):
        jump = re.search(r"bra(?:\.uni)?\s+(\$L\w+);", line)
        if jump and labels[jump[1]] < i:
            loops.append((labels[jump[1]], i))
    inner = [a for a in loops if not any(a != b and a[0] <= b[0] and b[1] <= a[1] for b in loops)]
    bodies = [
        [line.split()[0 if not line.startswith("@") else 1] for line in lines[a:b] if line.endswith(";")]
        for a, b in inner
    ]
    return max((Counter(body) for body in bodies), key=lambda body: sum(n for name, n in body.items() if "f" in name))


def total(counts, *names):
    """Number of instructions whose names begin so, up to a dot."""
    return sum(count for found, count in counts.items() if any(f"{found}.".startswith(f"{name}.") for name in names))


def digits(value, precision):
    """A number as PTX writes it."""
    if precision == "float32":
        return f"0f{np.float32(value).view(np.uint32):08X}"
    return f"0d{np.float64(value).view(np.uint64):016X}"
