"""Values of a graph whose check finds every infinite or NaN input and result.

Sums, differences, products, roots and the numerator of a quotient pass on what is not finite: nothing that is added or
multiplied makes it finite again. So what flows by such operations alone into a value that is looked at need not be looked
at itself. One sum of the few that remain tells of all, since it is finite only if they are.
"""

from collections.abc import Iterable
from typing import Any

from plant.backends.tracing import Node, reachable

# Operation -> the arguments whose infinities and NaNs the result cannot hide; a quotient hides an infinite divisor.
PASSES_ON = {
    "+": (0, 1),
    "-": (0, 1),
    "*": (0, 1),
    "/": (0,),
    "neg": (0,),
    "absolute": (0,),
    "floor": (0,),
    "sqrt": (0,),
}
# Results of a watched routine: its own sum tells of them.
WATCHED = "watched"


def to_look_at(values: Iterable[Any]) -> list[Node]:
    """Return the nodes whose being finite makes all the values finite: some of them, and the sums of watched routines."""
    given = [value for value in values if isinstance(value, Node)]
    sums = [node.graph.node("sum", node) for node in reachable(given) if node.op == "call" and node.text[0] == WATCHED]
    distinct = {value.order: value for value in given if value.text != WATCHED}
    nodes = [*distinct.values(), *sums]
    covered: set[int] = set()
    for node in nodes:
        covered |= _betrayed(node)
    return [node for node in nodes if node.order not in covered]


def _betrayed(node: Node) -> set[int]:
    """Return the orders of the other nodes that are finite where a node is."""
    seen: set[int] = set()
    stack = [node]
    while stack:
        for arg in _passed_on(stack.pop()):
            if isinstance(arg, Node) and arg.order not in seen:
                seen.add(arg.order)
                stack.append(arg)
    return seen


def _passed_on(node: Node) -> tuple[Any, ...]:
    if node.op == "sum":
        return node.args[0].args
    return tuple(node.args[i] for i in PASSES_ON.get(node.op, ()))
