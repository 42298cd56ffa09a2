"""The trace backend: a model function run on symbols leaves the graph of its operations, in the order of its source.

For code generators. Operations keep their order and none is left out but those that change no bit (times 1, minus 0); what
depends on constants alone is worked out at once in Python floats, so a `select` on them leaves one branch, as a run of the model
function on constants would. The same operation on the same arguments is one node.
"""

import math
import operator
from collections.abc import Callable
from typing import Any

from plant import primitives
from plant.backends import vector_math
from plant.backends.rebind import Rebinder
from plant.records import pack, paths

OPERATIONS = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}


def _methods(made: Callable[[str, Any, Any], Any], sign: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return the method of an operator and that of its reflection."""
    return (lambda self, other: made(sign, self, other)), (lambda self, other: made(sign, other, self))


def _node(sign: str, a: Any, b: Any) -> Any:
    return (a if isinstance(a, Node) else b).graph.node(sign, a, b)


def text_of(value: float) -> str:
    """Return the expression a constant comes from; its digits if it is a number of the source."""
    return value.text if isinstance(value, Constant) else repr(value)


def _factor(value: float) -> str:
    text = text_of(value)
    return f"({text})" if " " in text else text


def _constant(sign: str, a: Any, b: Any) -> Any:
    if isinstance(a, Node) or isinstance(b, Node):
        return NotImplemented
    if sign in ("*", "/") and _is_number(b, 1.0):
        return a
    left = text_of(a) if sign == "+" or all(f" {other} " not in text_of(a) for other in "+-") else _factor(a)
    return Constant(OPERATIONS[sign](float(a), float(b)), f"{left} {sign} {_factor(b)}")


class Constant(float):
    """A float with its expression, such as "h * constants.ki"; arithmetic on constants carries it on."""

    text: str

    def __new__(cls, value: float, text: str) -> "Constant":
        """Make the constant of that value."""
        self = super().__new__(cls, value)
        self.text = text
        return self

    __add__, __radd__ = _methods(_constant, "+")
    __sub__, __rsub__ = _methods(_constant, "-")
    __mul__, __rmul__ = _methods(_constant, "*")
    __truediv__, __rtruediv__ = _methods(_constant, "/")

    def __neg__(self) -> Any:
        return Constant(-float(self), f"-{_factor(self)}")


class Node:
    """One operation of a graph: its name and arguments, which are nodes or floats; made by `Graph.node` only.

    text: what an input is called, or the label of a call. order: place in the graph, arguments before what they serve.
    """

    __slots__ = ("args", "graph", "op", "order", "text")

    def __init__(self, graph: "Graph", op: str, args: tuple[Any, ...], text: Any, order: int) -> None:
        self.graph = graph
        self.op = op
        self.args = args
        self.text = text
        self.order = order

    __add__, __radd__ = _methods(_node, "+")
    __sub__, __rsub__ = _methods(_node, "-")
    __mul__, __rmul__ = _methods(_node, "*")
    __truediv__, __rtruediv__ = _methods(_node, "/")
    __lt__ = _methods(_node, "<")[0]
    __le__ = _methods(_node, "<=")[0]
    __gt__ = _methods(_node, ">")[0]
    __ge__ = _methods(_node, ">=")[0]

    def __neg__(self) -> Any:
        return self.graph.node("neg", self)

    def __bool__(self) -> bool:
        raise TypeError("a model function has no `if` on a value; `select` chooses")

    def __eq__(self, other: object) -> Any:
        if self is other:
            return True
        raise TypeError("a model function compares values by <, <=, > and >= only")

    __hash__ = object.__hash__


class Graph:
    """The operations of one trace; equal ones are one node."""

    def __init__(self) -> None:
        self._nodes: dict[Any, Node] = {}

    def node(self, op: str, *args: Any, text: Any = "") -> Any:
        """Return the node of an operation, or its argument where no bit changes."""
        if op == "*" and _is_number(args[0], 1.0):
            return args[1]
        if op in ("*", "/") and _is_number(args[1], 1.0):
            return args[0]
        if op == "-" and _is_number(args[1], 0.0):
            return args[0]
        key = (op, tuple(map(_key, args)), text)
        if key not in self._nodes:
            self._nodes[key] = Node(self, op, args, text, len(self._nodes))
        return self._nodes[key]

    def input(self, text: str) -> Node:
        """Return the input of that name."""
        return self.node("input", text=text)

    def inputs(self, kind: Any, prefix: str) -> Any:
        """Return a record of inputs, each called prefix + its path."""
        return pack(kind, [self.input(prefix + path) for path in paths(kind)])

    def all_inputs(self) -> list[Node]:
        """Return every input, whether anything depends on it or not."""
        return [node for node in self._nodes.values() if node.op == "input"]


def _is_number(value: Any, number: float) -> bool:
    """Return True if a value is that number of the source; a gain that happens to have its value is not."""
    return type(value) is float and value == number and math.copysign(1.0, value) == 1.0


def _key(value: Any) -> Any:
    return (value.order,) if isinstance(value, Node) else (float(value).hex(), text_of(value))


def reachable(results: list[Any]) -> list[Node]:
    """Return the nodes that results depend on, arguments first."""
    seen: dict[int, Node] = {}
    stack = [result for result in results if isinstance(result, Node)]
    while stack:
        node = stack.pop()
        if node.order not in seen:
            seen[node.order] = node
            stack.extend(arg for arg in node.args if isinstance(arg, Node))
    return [seen[order] for order in sorted(seen)]


def _graph_of(*values: Any) -> Graph | None:
    return next((value.graph for value in values if isinstance(value, Node)), None)


def _traced(name: str) -> Callable[..., Any]:
    """Return a primitive that adds a node, or evaluates constant arguments."""
    meaning = getattr(primitives, name)

    def operation(*args: Any) -> Any:
        graph = _graph_of(*args)
        if graph is None:
            return Constant(float(meaning(*map(float, args))), f"{name}({', '.join(map(text_of, args))})")
        return graph.node(name, *args)

    return operation


def _refused(name: str) -> Callable[..., Any]:
    meaning = getattr(primitives, name)

    def operation(a: Any) -> Any:
        if isinstance(a, Node):
            raise TypeError(f"'{name}' of a signal has no code: only what `prepare` works out may use it")
        return Constant(meaning(float(a)), f"{name}({text_of(a)})")

    return operation


def _clip(a: Any, low: Any, high: Any) -> Any:
    return NAMES["minimum"](NAMES["maximum"](a, low), high)


def _select(condition: Any, if_true: Any, if_false: Any) -> Any:
    if not isinstance(condition, Node):
        return if_true if condition else if_false
    return condition.graph.node("select", condition, if_true, if_false)


def _sign(a: Any) -> Any:
    return _select(a > 0.0, 1.0, _select(a < 0.0, -1.0, 0.0))


def _both(a: Any, b: Any) -> Any:
    if isinstance(a, Node) and isinstance(b, Node):
        return a.graph.node("both", a, b)
    constant, other = (b, a) if isinstance(a, Node) else (a, b)
    return other if constant else False


def _either(a: Any, b: Any) -> Any:
    if isinstance(a, Node) and isinstance(b, Node):
        return a.graph.node("either", a, b)
    constant, other = (b, a) if isinstance(a, Node) else (a, b)
    return True if constant else other


NAMES: dict[str, Any] = {
    **{name: _traced(name) for name in ("absolute", "floor", "maximum", "minimum", "sqrt")},
    **{name: _refused(name) for name in ("cos", "exp", "log", "sin", "tan", "tanh")},
    "both": _both,
    "clip": _clip,
    "either": _either,
    "select": _select,
    "sign": _sign,
}


def rebinder(stand_ins: dict[Callable[..., Any], Callable[..., Any]] | None = None) -> Rebinder:
    """Return a rebinder to graph operations; stand_ins: what is called in place of a model function, e.g. a `Routine`.

    Arc tangent, arc sine and hypot are model functions, for which there may be stand-ins too.
    """
    inner = Rebinder(NAMES, stand_ins=stand_ins)
    written_out = {"atan2": inner(vector_math.atan2), "asin": inner(vector_math.asin), "hypot": inner(primitives.hypot)}
    return Rebinder(NAMES | written_out, stand_ins=stand_ins)
