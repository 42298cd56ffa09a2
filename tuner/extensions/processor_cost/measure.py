"""Counting what a controller costs: its C code on a Cortex-M4F in QEMU, driven by the inputs of a short flight.

The controller is a compilation unit of its own, so nothing of a step can move out of the counted section. After a change of a
law, of the cascade or of the C99 export, the packaged table is updated by

    python -m tuner.extensions.processor_cost.measure --write tuner/extensions/processor_cost/cortex_m4f.json
"""

import argparse
import json
import re
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from plant.errors import InputError
from plant.law_registry import LAWS, law
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions
from plant.quadrotor.sensors import Measurement
from plant.records import paths
from plant.references.track import Reference
from plant.texts import PlainTable
from tuner.exchange.c99.quadrotor import c_sources
from tuner.exchange.texts import filled
from tuner.extensions.processor_cost import qemu
from tuner.extensions.processor_cost.cost import (
    CONTROL_PERIOD,
    COUNTED_KEYS,
    MEANING,
    SHARED_KEYS,
    TARGET,
    ProcessorCost,
)
from tuner.extensions.processor_cost.inputs import Instant, attitude_row, step_row, typical_inputs
from tuner.gains import Controller

PREFIX, REAL = "gainproof", "float"
# Sections of an object file that a processor's flash has to hold.
FLASH = (".text", ".rodata", ".data")
STACK_FLAGS = ("-fcallgraph-info=su",)


def measure_cost(controller: Controller) -> ProcessorCost:
    """Count the cost of a controller; raises InputError where compiler or emulator are missing."""
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
    return ProcessorCost(
        TARGET,
        _mean(attitude),
        max(attitude),
        _mean(step),
        max(step),
        flash,
        head[0],
        stack,
        compiler,
        emulator,
        " ".join(flag for flag in qemu.FLAGS if flag.startswith(("-O", "-ffp", "-fno"))),
    )


def flash_bytes(folder: Path, name: str) -> int:
    """Return the bytes of code and constants in an object file."""
    listed = qemu.call(["arm-none-eabi-size", "-A", name], folder)
    rows = re.findall(r"^(\.\S+)\s+(\d+)", listed, re.MULTILINE)
    return sum(int(size) for section, size in rows if section.startswith(FLASH))


def deepest_stack(graph: str, entry: str) -> int:
    """Return the stack of a function and its calls [bytes]: from gcc's call graph, without library functions such as memcpy."""
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


AIRFRAME, PLANT_STEP = "hummingbird", 0.001


def default_controller(position: str, attitude: str) -> Controller:
    """Return the default gains of a pair of laws; raises UnknownNameError."""
    cascade = close_cascade(law(position), law(attitude))
    return Controller(
        load(AIRFRAME), cascade, ControlOptions(), CONTROL_PERIOD, PLANT_STEP, tuple(default_row(cascade))
    )


def measured_table(on_progress: Callable[[str], None]) -> str:
    """Count every pair of laws and return the table as text; on_progress: called with a line for each."""
    costs: dict[str, dict[str, ProcessorCost]] = {}
    for position in LAWS:
        for attitude in LAWS:
            cost = measure_cost(default_controller(position, attitude))
            costs.setdefault(position, {})[attitude] = cost
            on_progress(f"{position} / {attitude}: {cost.instructions_step} instructions")
    return table_text(costs)


def table_text(costs: dict[str, dict[str, ProcessorCost]]) -> str:
    """Return a table as JSON with a line for each pair."""
    first = vars(next(iter(next(iter(costs.values())).values())))
    head: PlainTable = {"meaning": MEANING, **{key: first[key] for key in SHARED_KEYS}}
    head |= {"airframe": AIRFRAME, "control_period_s": CONTROL_PERIOD, "columns": list(COUNTED_KEYS)}
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}," for key, value in head.items()]
    blocks = [
        f"    {json.dumps(position)}: {{\n" + ",\n".join(_line(name, cost) for name, cost in rows.items()) + "\n    }"
        for position, rows in costs.items()
    ]
    return "{\n" + "\n".join(lines) + '\n  "costs": {\n' + ",\n".join(blocks) + "\n  }\n}\n"


def _line(name: str, cost: ProcessorCost) -> str:
    values = vars(cost)
    return f"      {json.dumps(name)}: {json.dumps([values[key] for key in COUNTED_KEYS])}"


def write_table(path: Path, on_progress: Callable[[str], None]) -> None:
    """Count every pair of laws and write the table."""
    path.write_text(measured_table(on_progress), encoding="utf-8")


ATTITUDE_MEMBERS = (
    *(f"setpoint.{name}" for name in ("roll", "pitch", "yaw", "yaw_rate")),
    *(f"seen.{name}.{axis}" for name in ("angles", "rate") for axis in "xyz"),
    *(f"applied.{name}.{axis}" for name in ("effect", "excess") for axis in "xyz"),
)
STEP_MEMBERS = (
    *(f"reference.{path}" for path in paths(Reference)),
    *(f"measurement.{path}" for path in paths(Measurement)),
)


def measuring_program(instants: Sequence[Instant], header: str, prefix: str, real: str) -> str:
    """Return the C source of the program.

    It prints the sizes of the state of the cascade and of the attitude loops [bytes]; for every instant the instructions of the
    attitude step and of the step of the cascade, each from before its call to after its return; last, thrust of the cascade [N]
    and torque of the attitude loops [N m], which tell that both were given what was recorded.
    """
    return filled(
        "tuner.extensions.processor_cost",
        "main.c",
        header=header,
        prefix=prefix,
        real=real,
        count=len(instants),
        step_width=len(STEP_MEMBERS),
        attitude_width=len(ATTITUDE_MEMBERS),
        step_rows=_rows(map(step_row, instants)),
        attitude_rows=_rows(map(attitude_row, instants)),
        take_step=_assignments(STEP_MEMBERS),
        take_attitude=_assignments(ATTITUDE_MEMBERS),
    )


def _rows(rows: Iterable[Sequence[float]]) -> str:
    """Return numbers in hexadecimal, so that none is rounded twice."""
    return ",\n".join("    {" + ", ".join(float(value).hex() for value in row) + "}" for row in rows)


def _assignments(members: Sequence[str]) -> str:
    return "\n".join(f"    {member} = in[{i}];" for i, member in enumerate(members))


def main() -> int:
    """Write the table; exit code 2 where the toolchain is missing."""
    parser = argparse.ArgumentParser(
        prog="python -m tuner.extensions.processor_cost.measure", description="Count every pair of laws again."
    )
    parser.add_argument(
        "--write", type=Path, required=True, help="the file to write, tuner/extensions/processor_cost/cortex_m4f.json"
    )
    try:
        write_table(parser.parse_args().write, lambda line: print(line, flush=True))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
