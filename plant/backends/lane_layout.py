"""Places of a flight in the lanes' workspace and results. Needs no compiler, whose import takes 0.4 s of a command's start."""

from dataclasses import dataclass

from plant.loop import ClosedLoop
from plant.records import rows, size

# 16 doubles fill two AVX-512 or four AVX2 registers. With 8 the loop is two AVX2 or one AVX-512 step long, and LLVM may unroll it
# whole and leave it scalar (seen on a Zen 4 with AVX-512, not on a Zen 3 with AVX2).
LANES = 16


@dataclass(frozen=True)
class Layout:
    """Rows of the workspace: the flight first, then dynamics, disturbance and noise."""

    flight: int
    dynamics: int
    disturbance: int
    noise: int
    total: int


def layout(loop: ClosedLoop) -> Layout:
    """Return the offset of each record in the workspace of a loop."""
    kinds = loop.records
    flight, dynamics = size(loop.Flight), size(kinds.Dynamics)
    disturbance = flight + dynamics
    noise = disturbance + size(kinds.Disturbance)
    return Layout(0, flight, disturbance, noise, noise + size(kinds.Noise))


def result_rows(loop: ClosedLoop) -> slice:
    """Rows of the flight that a kernel returns: meters, status, end time (they stand last)."""
    return slice(rows(loop.Flight, "meters").start, size(loop.Flight))
