"""Routines: model functions that generated code calls instead of repeating them.

A routine stands in for a model function while others are traced, and notes each call. Arguments that are constants in every
call are no parameters: the function is traced for each call with their values, and calls that leave the same operations share one
body, whose constants are the call's table. So what a gain and the period come to, h * ki, is worked out beforehand, call by call.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from plant.backends.tracing import Constant, Graph, Node, reachable, rebinder, text_of
from plant.backends.tracing_finite import WATCHED, to_look_at
from plant.records import flatten, pack, size


@dataclass(frozen=True)
class Call:
    """One call: its label, and the flattened arguments without memory."""

    label: str
    args: tuple[Any, ...]


@dataclass(frozen=True)
class SharedRoutine:
    """The part that calls share.

    Attributes:
        parameters: names of the arguments that vary.
        results: value, memory, and last the sum to look at.
        tables: text of a constant -> its value for each label; numbers that hold no gain and are alike in all
            calls stand in the code instead.
    """

    parameters: tuple[str, ...]
    results: tuple[Any, ...]
    tables: dict[str, dict[str, float]]
    labels: tuple[str, ...]


class Routine:
    """A model function as a callable of generated code, under a name.

    memory: record type of its first argument, which the code passes by address, or None. watched: whether it also returns
    the sum that tells whether all it takes and gives is finite.
    """

    def __init__(self, name: str, function: Callable[..., Any], memory: Any = None, watched: bool = False) -> None:
        self.name = name
        self.function = function
        self.memory = memory
        self.watched = watched
        self.calls: list[Call] = []
        code: Any = function.__code__
        self._arguments = code.co_varnames[: code.co_argcount]
        self._shapes: tuple[Any, ...] = ()

    def call(self, label: str, graph: Graph, *args: Any) -> Any:
        """Note a call and return its results: (value, memory) with a memory, else the value."""
        self._shapes = args
        given = args[1:] if self.memory else args
        flat = tuple(leaf for arg in given for leaf in _leaves(arg))
        self.calls.append(Call(label, flat))
        kind = WATCHED if self.watched else ""
        node = graph.node("call", *flat, text=(kind, self.name, label))
        value = graph.node("value", node, text=kind)
        if not self.memory:
            return value
        after = [graph.node("after", node, float(i), text=kind) for i in range(size(self.memory))]
        return value, pack(self.memory, after)

    def bodies(self) -> list[SharedRoutine]:
        """Return the bodies that serve all calls: one, unless their constants leave different operations."""
        varying = self._varying()
        groups: dict[Any, list[tuple[str, list[Any]]]] = {}
        for call in {call.label: call for call in self.calls}.values():
            results = self._traced(call, varying)
            groups.setdefault(_shape(results), []).append((call.label, results))
        return [_merged(self._parameters(varying), members) for members in groups.values()]

    def passed(self, args: Sequence[Any]) -> list[Any]:
        """Return the arguments of a call that are parameters."""
        return [arg for arg, varies in zip(args, self._varying(), strict=True) if varies]

    def _varying(self) -> list[bool]:
        return [any(isinstance(call.args[i], Node) for call in self.calls) for i in range(len(self.calls[0].args))]

    def _names(self) -> list[str]:
        """Name of each flattened argument without memory, such as "constants.kp"."""
        skip = 1 if self.memory else 0
        return [
            f"{name}.{path}" if path else name
            for name, shape in zip(self._arguments[skip:], self._shapes[skip:], strict=True)
            for path in _paths(shape)
        ]

    def _parameters(self, varying: list[bool]) -> tuple[str, ...]:
        return tuple(parameter(name) for name, varies in zip(self._names(), varying, strict=True) if varies)

    def _traced(self, call: Call, varying: list[bool]) -> list[Any]:
        graph = Graph()
        shared = [len({other.args[i] for other in self.calls}) == 1 for i in range(len(varying)) if not varying[i]]
        alike = iter(shared)
        leaves = [
            graph.input(parameter(name)) if varies else _given(name, value, next(alike))
            for name, value, varies in zip(self._names(), call.args, varying, strict=True)
        ]
        inputs = [leaf for leaf in leaves if isinstance(leaf, Node)]
        stream = iter(leaves)
        arguments = [graph.inputs(self.memory, "m->")] if self.memory else []
        arguments += [_like(shape, stream) for shape in self._shapes[len(arguments) :]]
        returned = rebinder()(self.function)(*arguments)
        results = flatten(returned) if isinstance(returned, tuple) else [returned]
        if self.watched:
            looked_at = to_look_at([*results, *inputs])
            results.append(sum(looked_at[1:], looked_at[0]))
        return results


def parameter(name: str) -> str:
    """Return the name of a parameter: its path with underscores."""
    return name.replace(".", "_")


def _given(name: str, value: float, alike: bool) -> float:
    # A number of the source that all calls share, such as b0 = 1, may drop out; a gain of 1 may not, lest bodies differ by gains.
    return float(value) if alike and value == 1.0 and not name.startswith("constants.") else Constant(value, name)


def _leaves(value: Any) -> list[Any]:
    return flatten(value) if isinstance(value, tuple) else [value]


def _paths(shape: Any) -> Iterator[str]:
    if not isinstance(shape, tuple):
        yield ""
        return
    fields: tuple[str, ...] = shape._fields  # pyright: ignore[reportAttributeAccessIssue]
    for name, part in zip(fields, shape, strict=True):
        for path in _paths(part):
            yield f"{name}.{path}" if path else name


def _like(shape: Any, leaves: Iterator[Any]) -> Any:
    return type(shape)(*[_like(part, leaves) for part in shape]) if isinstance(shape, tuple) else next(leaves)


def _shape(results: list[Any]) -> Any:
    """Return a key of a trace that ignores the values of its constants."""
    place = {node.order: i for i, node in enumerate(reachable(results))}

    def name(value: Any) -> Any:
        return place[value.order] if isinstance(value, Node) else text_of(value)

    nodes = tuple((node.op, node.text, tuple(map(name, node.args))) for node in reachable(results))
    return nodes, tuple(map(name, results))


def _merged(parameters: tuple[str, ...], members: list[tuple[str, list[Any]]]) -> SharedRoutine:
    tables: dict[str, dict[str, float]] = {}
    for label, results in members:
        for node in reachable(results):
            for arg in node.args:
                if isinstance(arg, Constant):
                    tables.setdefault(arg.text, {})[label] = float(arg)
    varying = {
        text: values
        for text, values in tables.items()
        if "constants." in text or len({v.hex() for v in values.values()}) > 1
    }
    return SharedRoutine(parameters, tuple(members[0][1]), varying, tuple(label for label, _ in members))
