"""What a contestant is: how it is called, what it needs installed, and how it gets ready to fly a batch."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from benchmarks.course import Course

Work = Callable[[], Any]
Prepare = Callable[[Course, int, int, int, Path], Work]


@dataclass(frozen=True)
class Contestant:
    """One way to fly.

    module: in this folder; it has `prepare(course, batch, periods, threads, scratch)`, which compiles what there is to
    compile and returns the flight as a call. environment: name of its own environment, or "" for the one of the package.
    requires: what that environment installs. threads: how many it may use, 0 for all. same: whether it flies our model, else
    its own closed loop. largest: batch that it is asked for; beyond it a round would take minutes. budget, periods: plant
    steps that it flies a round and control periods of a flight, at most; where a step costs much whatever the batch, flights
    are short.
    """

    name: str
    module: str
    note: str
    environment: str = ""
    requires: tuple[str, ...] = ()
    threads: int = 0
    same: bool = True
    largest: int = 65_536
    budget: int = 400_000
    periods: int = 2500

    def prepare(self) -> Prepare:
        """Return the function that gets it ready; only its own environment can import it."""
        return import_module(f"benchmarks.peers.{self.module}").prepare


CONTESTANTS = (
    Contestant("lanes", "lanes", "this package, all threads; up to 64 flights are one candidate, one thread's", budget=4_000_000),
    Contestant("lanes, one thread", "lanes", "this package, one thread", threads=1, budget=4_000_000),
    Contestant("C", "ceiling", "by hand, the model's own algebra, all threads", budget=4_000_000),
    Contestant("C, one thread", "ceiling", "by hand, the model's own algebra, one thread", threads=1, budget=4_000_000),
    Contestant("C with shortcuts, one thread", "ceiling_short", "by hand, algebra of this course", threads=1, budget=4_000_000),
    Contestant("NumPy", "vectorised", "the model's functions on arrays", threads=1, budget=200_000, periods=25),
    Contestant("JAX float64", "jax_scan", "jit(vmap(scan)) of the model's functions", "jax", ("jax", "numpy")),
    Contestant(
        "crazyflow", "crazyflow_loop", "its own Crazyflie and Mellinger controller, RK4, float32, no wind, no meters",
        "crazyflow", ("crazyflow",), same=False,
    ),
    Contestant(
        "RotorPy batched", "rotorpy_loop", "its own Hummingbird and SE(3) controller, RK4, motor noise, no wind, no meters",
        "rotorpy", ("rotorpy", "torch", "torchdiffeq", "roma"), same=False, budget=60_000, periods=10, largest=64,
    ),
    Contestant(
        "python-control", "python_control", "the model's functions through input_output_response, one flight", threads=1,
        largest=1,
        periods=50,
    ),
)  # fmt: skip
