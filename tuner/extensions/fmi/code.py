"""binding.h: what ties the general FMI code to one controller, written as C."""

import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from plant.errors import InputError
from tuner.exchange.texts import filled
from tuner.extensions.fmi.variables import FmuVariable
from tuner.gains import Controller

AT_ONCE = "The outputs are the command that the controller puts in force."
AHEAD = (
    "The controller was tuned for a command that comes into force one period after its measurement. A co-simulation makes that "
    "period itself, so the outputs are the command that a further step would put in force."
)
FURTHER_STEP = """\
    if (status == 0) {
        gainproof_state ahead = *state;
        status = (int)gainproof_step(&ahead, &reference, &measurement, &command);
    }
"""


def binding(controller: Controller, exposed: Sequence[FmuVariable], heading: Sequence[str], guid: str) -> str:
    """Return binding.h, which ties the general FMI code to a controller."""
    delayed = controller.options.delay
    words = {"when": AHEAD if delayed else AT_ONCE, "ahead": FURTHER_STEP if delayed else ""}
    return filled_binding("binding.h", controller.control_period, exposed, heading, guid=guid, **words)


def filled_binding(
    template: str, period: float, exposed: Sequence[FmuVariable], heading: Sequence[str], **words: str
) -> str:
    """Return binding.h of a template.

    Args:
        template: Name of the template.
        period: Control period [s].
        exposed: Variables of the FMU.
        heading: Lines at its top.
        words: Further words of the template, among them the GUID.
    """
    inputs, outputs, constants = ([entry for entry in exposed if entry.kind == kind] for kind in KINDS)
    return filled(
        "tuner.extensions.fmi",
        template,
        heading="\n   ".join(heading),
        period=period,
        period_text=f"{period:.10g}",
        inputs=len(inputs),
        outputs=len(outputs),
        constants=len(constants),
        start_inputs=_values(inputs),
        start_outputs=_values(outputs),
        constant_values=_values(constants),
        take="\n".join(f"    {entry.member} = (gainproof_real)in[{i}];" for i, entry in enumerate(inputs)),
        give="\n".join(f"    out[{i}] = (double)command.{entry.member};" for i, entry in enumerate(outputs)),
        **words,
    )


KINDS = ("input", "output", "constant")


def _values(entries: Sequence[FmuVariable]) -> str:
    return "\n".join(f"    {float(entry.start)!r}, /* {entry.name} [{entry.unit}] */" for entry in entries)


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
    machine = subprocess.run([gcc, "-dumpmachine"], capture_output=True, encoding="utf-8", errors="replace").stdout
    return gcc if machine.startswith("x86_64") and "linux" in machine else None


def shared_library(sources: Mapping[str, str], units: Sequence[str], gcc: str) -> bytes:
    """Compile sources (name -> text) and return the library; units: the files to compile."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        for name, text in sources.items():
            (folder / name).write_text(text, encoding="utf-8")
        done = subprocess.run(
            [gcc, *FLAGS, *units, "-o", "library.so", *LINKING],
            cwd=folder,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
        )
        if done.returncode != 0:
            raise InputError(f"gcc could not compile the FMU: {done.stderr.strip()[-2000:]}", key="--to")
        return (folder / "library.so").read_bytes()
