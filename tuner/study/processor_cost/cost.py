"""Cost of a controller on one processor."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

TARGET = "Cortex-M4F"
MEANING = (
    "instructions of a control step with its call, which takes 5 or 6 of them; mean and largest over a 2 s flight with 1 m steps "
    "in moderate turbulence, counted in an emulator. Instructions are not cycles: a Cortex-M4F takes 14 for a division or a "
    "root, and waits for flash"
)


@dataclass(frozen=True)
class Cost:
    """Counts of a controller in single precision.

    instructions_attitude, instructions_step: mean instructions of a step of the three attitude loops, and of the whole
    cascade; most_attitude, most_step: largest seen. text_bytes: code and constants; state_bytes: the cascade's state;
    stack_bytes: deepest stack of the cascade's step. compiler, emulator, flags: with which that was counted.
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

    def as_dict(self) -> dict[str, Any]:
        """Return the counts as data for JSON."""
        return asdict(self)


def cost_from(values: Mapping[str, Any]) -> Cost:
    """Return the counts that `as_dict` wrote."""
    return Cost(**values)
