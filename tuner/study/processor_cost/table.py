"""The packaged table of costs: the default gains of every pair of laws on the Hummingbird, counted once and for all machines.

Counts hang on the laws, hardly on the gains, so the table stands in where no compiler for a Cortex-M4F is installed, and studies
use nothing else: what they find must not depend on what is installed. `tuner.exchange.processor_cost.measure` makes it.
"""

import json
from functools import cache
from importlib.resources import files

from tuner.study.processor_cost.cost import Cost, cost_from

CONTROL_PERIOD = 0.004
FILE = "cortex_m4f.json"
# What is the same for all pairs of a table, and what is counted for each.
SHARED = ("target", "compiler", "emulator", "flags")
COUNTED = (
    "instructions_attitude", "most_attitude", "instructions_step", "most_step", "text_bytes", "state_bytes", "stack_bytes",
)  # fmt: skip


def tabled(position: str, attitude: str) -> Cost | None:
    """Return the packaged cost of a pair of laws, or None for a law that is younger than the table."""
    return _packaged().get((position, attitude))


@cache
def _packaged() -> dict[tuple[str, str], Cost]:
    return read_table(files("tuner.study.processor_cost").joinpath(FILE).read_text(encoding="utf-8"))


def read_table(text: str) -> dict[tuple[str, str], Cost]:
    """Return the costs of a table by position law and attitude law."""
    content = json.loads(text)
    shared = {key: content[key] for key in SHARED}
    return {
        (position, attitude): cost_from(shared | dict(zip(content["columns"], counts, strict=True)))
        for position, rows in content["costs"].items()
        for attitude, counts in rows.items()
    }
