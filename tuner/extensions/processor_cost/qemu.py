"""Programs for a Cortex-M4F, built with gcc and run in QEMU.

The board is QEMU's model of the mps2-an386. `build` turns C sources with a `main` into an ELF file, `run_elf` runs it
and returns what it printed. Virtual time advances by 1024 ns an instruction (`-icount shift=10`), so a run is the same
to the last instruction on every machine and at every load.
"""

import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path

from plant.errors import InputError

COMPILER, EMULATOR = "arm-none-eabi-gcc", "qemu-system-arm"
CPU = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
# Multiply and add are not contracted, so that results are the bits of any other IEEE machine.
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-ffunction-sections", "-fdata-sections")
MACHINE = ("-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none", "-icount", "shift=10")
BOARD = ("startup.c", "ticks.h", "mps2_an386.ld")
# Wall-clock limit of a run [s]; a measurement takes less than one.
PATIENCE = 120.0
REMEDY = "on Debian: apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm"


def missing() -> list[str]:
    """Return the programs that are needed here and not installed."""
    return [program for program in (COMPILER, EMULATOR) if shutil.which(program) is None]


def require() -> None:
    """Raise InputError where the toolchain is not installed."""
    absent = missing()
    if absent:
        raise InputError(f"{' and '.join(absent)} not installed; {REMEDY}")


def versions() -> tuple[str, str]:
    """Return name and version of compiler and emulator, e.g. ("arm-none-eabi-gcc 12.2.1", "qemu-system-arm 7.2.22")."""
    return _version(COMPILER), _version(EMULATOR)


def build(sources: Mapping[str, str], folder: Path, flags: Sequence[str] = FLAGS) -> Path:
    """Write sources (name -> text; headers next to them) into a folder, compile and link them with the board's own start.

    Any `int main(void)` with printf will do. Returns the ELF file; its object files, named after the sources, stay next to it.
    Raises InputError with the compiler's words where it refuses.
    """
    require()
    write(sources, folder)
    for name in BOARD:
        (folder / name).write_text(
            files("tuner.extensions.processor_cost").joinpath("board", name).read_text(encoding="utf-8"),
            encoding="utf-8",
        )
    units = [name for name in sources if name.endswith(".c")]
    objects = [compiled(folder, name, flags) for name in units]
    objects.append(compiled(folder, "startup.c", ("-std=c99", "-O2")))
    elf = folder / "program.elf"
    linking = ("-nostartfiles", "--specs=rdimon.specs", "-Wl,--gc-sections", "-T", "mps2_an386.ld")
    call([COMPILER, *CPU, *objects, *linking, "-lm", "-o", elf.name], folder)
    return elf


def write(sources: Mapping[str, str], folder: Path) -> None:
    """Write sources into a folder, which is made if need be."""
    for name, text in sources.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def compiled(folder: Path, source: str, flags: Sequence[str] = FLAGS) -> str:
    """Compile one source of a folder; return the name of its object file."""
    target = f"{source.removesuffix('.c')}.o"
    call([COMPILER, *CPU, *flags, "-I.", "-c", source, "-o", target], folder)
    return target


def run_elf(elf: Path) -> str:
    """Run a program to its end and return its standard output; InputError where it fails or does not end."""
    semihosting = ("-semihosting-config", "enable=on,target=native")
    return call([EMULATOR, *MACHINE, *semihosting, "-kernel", elf.name], elf.parent)


def call(command: Sequence[str], folder: Path) -> str:
    """Run a program in a folder and return its standard output; InputError with its last words where it fails."""
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=PATIENCE,
            stdin=subprocess.DEVNULL,
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"{command[0]} did not end within {PATIENCE:g} s") from None
    if done.returncode != 0:
        output = (done.stderr or done.stdout).strip()[-2000:]
        raise InputError(f"{command[0]} ended with status {done.returncode}: {output}")
    return done.stdout


def _version(program: str) -> str:
    line = call([program, "--version"], Path.cwd()).splitlines()[0]
    numbers = re.findall(r"\d+\.\d+\.\d+", line)
    return f"{program} {numbers[-1] if program == COMPILER else numbers[0]}"
