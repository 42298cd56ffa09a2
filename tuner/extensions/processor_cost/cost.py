"""Cost of a controller on one processor, with a packaged table.

The table holds the default gains of every pair of laws on the Hummingbird, counted once and for all machines. Counts hang on the
laws, hardly on the gains, so it stands in where no compiler for a Cortex-M4F is installed, and studies use nothing else: what
they find must not depend on what is installed. `tuner.extensions.processor_cost.measure` makes it.
"""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from tuner.study.step_costs import StepCosts

TARGET = "Cortex-M4F"
MEANING = (
    "instructions of a control step with its call, which takes 5 or 6 of them; mean and largest over a 2 s flight with 1 m steps "
    "in moderate turbulence, counted in an emulator. Instructions are not cycles: a Cortex-M4F takes 14 for a division or a "
    "root, and waits for flash"
)


@dataclass(frozen=True)
class ProcessorCost:
    """Counts of a controller in single precision.

    Attributes:
        instructions_attitude, instructions_step: Mean instructions of a step, of attitude loops and of the full cascade.
        most_attitude, most_step: Largest numbers of these instructions.
        text_bytes: Code and constants.
        state_bytes: State of the cascade.
        stack_bytes: Deepest stack of the cascade's step.
        compiler, emulator, flags: Tools of the count, and their flags.
    """

    target: str
    instructions_attitude: float
    most_attitude: int
    instructions_step: float
    most_step: int
    text_bytes: int
    state_bytes: int
    stack_bytes: int
    compiler: str
    emulator: str
    flags: str

    @property
    def tool(self) -> str:
        """Compiler and emulator in one line."""
        return f"{self.compiler} ({self.flags}), {self.emulator}"

    def per_second(self, control_period: float) -> float:
        """Mean instructions of the cascade a second at a control period [s]."""
        return self.instructions_step / control_period


CONTROL_PERIOD = 0.004
FILE = "cortex_m4f.json"
# What is the same for all pairs of a table, and what is counted for each.
SHARED_KEYS = ("target", "compiler", "emulator", "flags")
COUNTED_KEYS = (
    "instructions_attitude",
    "most_attitude",
    "instructions_step",
    "most_step",
    "text_bytes",
    "state_bytes",
    "stack_bytes",
)


def tabled(position: str, attitude: str) -> ProcessorCost | None:
    """Return the packaged cost of a pair of laws, None without one."""
    return _packaged().get((position, attitude))


@cache
def _packaged() -> dict[tuple[str, str], ProcessorCost]:
    return read_table(files("tuner.extensions.processor_cost").joinpath(FILE).read_text(encoding="utf-8"))


def read_table(text: str) -> dict[tuple[str, str], ProcessorCost]:
    """Return the costs of a table by position law and attitude law."""
    content = json.loads(text)
    shared = {key: content[key] for key in SHARED_KEYS}
    return {
        (position, attitude): ProcessorCost(**shared, **dict(zip(content["columns"], counts, strict=True)))
        for position, rows in content["costs"].items()
        for attitude, counts in rows.items()
    }


def cost_text(position: str, attitude: str, control_period: float) -> str | None:
    """Return the cost of a pair of laws as a sentence part.

    None where the table does not have it.
    """
    cost = tabled(position, attitude)
    if cost is None:
        return None
    rate = 1e-6 * cost.per_second(control_period)
    return (
        f"{cost.instructions_step:.0f} instructions on a {cost.target}, {rate:.3g} million a second; {cost.text_bytes} bytes of "
        f"code, {cost.state_bytes} of state, {cost.stack_bytes} of stack"
    )


def gains_rows(cost: ProcessorCost | None) -> list[dict[str, Any]]:
    """Return the block "cost" of gains.json: instructions of a control step, bytes of code and constants."""
    if cost is None:
        return []
    return [
        {
            "target": cost.target,
            "tool": cost.tool,
            "instructions": {"value": cost.instructions_step, "unit": "1"},
            "bytes": {"value": cost.text_bytes, "unit": "By"},
        }
    ]


def count_fields(position: str, attitude: str, control_period: float) -> dict[str, Any] | None:
    """Return the fields of a `ProcessorCount`, None for laws without a count."""
    cost = tabled(position, attitude)
    if cost is None:
        return None
    return {**vars(cost), "instructions_per_second": cost.per_second(control_period), "meaning": MEANING}


COSTS = StepCosts(lambda position, attitude: gains_rows(tabled(position, attitude)), cost_text, count_fields)
