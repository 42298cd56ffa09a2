"""Counting what a controller costs: its C code on a Cortex-M4F in QEMU, driven by the inputs of a short flight.

The controller's code is compiled by itself with the flags of `qemu.FLAGS`; the program around it is another unit, so nothing of
a step can be moved out of the counted section.
"""

import re
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tuner.exchange.processor_cost import qemu
from tuner.exchange.processor_cost.inputs import typical_inputs
from tuner.exchange.processor_cost.program import measuring_program
from tuner.gains import Controller
from tuner.study.processor_cost.cost import TARGET, Cost

PREFIX, REAL = "holdfast", "float"
# Sections of an object file that a processor's flash has to hold.
FLASH = (".text", ".rodata", ".data")
STACK_FLAGS = ("-fcallgraph-info=su",)


def measure_cost(controller: Controller) -> Cost:
    """Count the cost of a controller; raises InputError where compiler or emulator are missing."""
    from tuner.exchange.c99.sources import c_sources

    qemu.require()
    code = c_sources(controller, REAL, PREFIX)
    main = measuring_program(typical_inputs(controller), f"{code.name}.h", PREFIX, REAL)
    sources = {f"{code.name}.h": code.header, f"{code.name}.c": code.source, "main.c": main}
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        elf = qemu.build(sources, folder, (*qemu.FLAGS, *STACK_FLAGS))
        head, *rows = (list(map(int, line.split())) for line in qemu.run_elf(elf).splitlines()[:-1])
        flash = flash_bytes(folder, f"{code.name}.o")
        stack = deepest_stack((folder / f"{code.name}.ci").read_text(encoding="utf-8"), f"{PREFIX}_step")
    attitude, step = ([row[i] for row in rows] for i in range(2))
    compiler, emulator = qemu.versions()
    return Cost(
        TARGET, _mean(attitude), max(attitude), _mean(step), max(step), flash, head[0], stack, compiler, emulator,
        " ".join(flag for flag in qemu.FLAGS if flag.startswith(("-O", "-ffp", "-fno"))),
    )  # fmt: skip


def flash_bytes(folder: Path, name: str) -> int:
    """Return the bytes of code and constants in an object file."""
    listed = qemu.call(["arm-none-eabi-size", "-A", name], folder)
    rows = re.findall(r"^(\.\S+)\s+(\d+)", listed, re.MULTILINE)
    return sum(int(size) for section, size in rows if section.startswith(FLASH))


def deepest_stack(graph: str, entry: str) -> int:
    """Return the bytes of stack that a function and all it calls need, from gcc's call graph; what library functions such as
    memcpy push is not in it.
    """
    frames = {name: int(size) for name, size in re.findall(r'title: "([^"]+)"[^\n]*?(\d+) bytes \(static\)', graph)}
    calls: dict[str, list[str]] = {}
    for caller, callee in re.findall(r'sourcename: "([^"]+)" targetname: "([^"]+)"', graph):
        calls.setdefault(caller, []).append(callee)

    def depth(name: str) -> int:
        return frames.get(name, 0) + max(map(depth, calls.get(name, [])), default=0)

    start = next(name for name in frames if name.split(":")[-1] == entry)
    return depth(start)


def _mean(counts: Sequence[int]) -> float:
    """Return the mean to a tenth of an instruction."""
    return round(sum(counts) / len(counts), 1)
