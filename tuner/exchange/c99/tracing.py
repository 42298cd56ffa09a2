"""Entry points of a controller as graphs."""

from dataclasses import dataclass
from typing import Any

from plant.backends.tracing import Constant, Graph
from plant.backends.tracing_finite import to_look_at
from plant.records import flatten, pack, paths

Results = tuple[tuple[str, Any], ...]
"""Records with what stands in front of the paths of their leaves."""


@dataclass(frozen=True)
class TracedFunction:
    """One traced function: (path of a result, value), and the sum that is finite only if all it takes and gives is."""

    results: tuple[tuple[str, Any], ...]
    sum: Any


def named(name: str, record: Any) -> Any:
    """Return a record of floats with named leaves; constants of a loop are "constants.kp"."""
    kind = type(record)

    def text(path: str) -> str:
        return f"constants.{path.partition('.')[2]}" if name else path.removeprefix("vehicle.")

    return pack(kind, [Constant(value, text(path)) for path, value in zip(paths(kind), flatten(record), strict=True)])


def traced(graph: Graph, given: Results) -> TracedFunction:
    """Return results by path, but for the memories that a routine fills; all inputs are looked at, used or not."""
    named_results = [
        (prefix + path, value)
        for prefix, record in given
        for path, value in zip(paths(type(record)), flatten(record), strict=True)
    ]
    written = [(path, value) for path, value in named_results if getattr(value, "op", "") != "after"]
    external = [node for node in graph.all_inputs() if not node.text.startswith("state->")]
    looked_at = to_look_at([*(value for _, value in written), *external])
    total = sum(looked_at[1:], looked_at[0])
    return TracedFunction(tuple(written), total)
