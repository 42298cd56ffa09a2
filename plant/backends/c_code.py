"""C99 statements of a traced graph, operation by operation in the order of the source.

In IEEE arithmetic without contraction (-ffp-contract=off) the statements give the same bits as the model function run in that
precision with minimum, maximum and select as Python has them. No function of the mathematical library is called but sqrt and
fabs, which compilers turn into one instruction; floor is written out.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from textwrap import TextWrapper
from typing import Any

import numpy as np

from plant.backends.tracing import Constant, Node, reachable, text_of

# Longest expression that is not given a name of its own.
LONGEST = 72
WIDTH, LONGEST_COMMENT = 112, 60


@dataclass(frozen=True)
class Real:
    """A floating-point type of C: name, suffix of its literals and functions, NumPy's type, integer type that
    holds all numbers that may have a fraction, the least power of two beyond which none has one, and
    the smallest and largest normal numbers.
    """

    name: str
    suffix: str
    dtype: Any
    integer_type: str
    largest_fraction: float
    least: float
    most: float


FLOAT = Real("float", "f", np.float32, "int32_t", 8388608.0, 2.0**-126, (2.0 - 2.0**-23) * 2.0**127)
DOUBLE = Real("double", "", np.float64, "int64_t", 4503599627370496.0, 2.0**-1022, (2.0 - 2.0**-52) * 2.0**1023)
REALS = {real.name: real for real in (FLOAT, DOUBLE)}


def rounded(value: float, real: Real) -> float:
    """Return a constant as the type holds it.

    One that is too small to be normal becomes the least normal number: it is there to keep a divisor from being 0.
    """
    assert abs(value) <= real.most, f"{value} has no {real.name}"
    if 0.0 < abs(value) < real.least:
        return real.least if value > 0.0 else -real.least
    return float(real.dtype(value))


def literal(value: float, real: Real, raised: bool = True) -> str:
    """Return the shortest exact C literal of a constant: negative ones in parentheses.

    raised: whether a constant that is not normal is raised as in `rounded`.
    """
    number = real.dtype(rounded(value, real) if raised else value)
    plain = number == 0.0 or 1e-4 <= abs(number) < 1e7
    write = np.format_float_positional if plain else np.format_float_scientific
    text = write(number, unique=True, trim="0") + real.suffix
    return f"({text})" if text.startswith("-") else text


INFIX = ("+", "-", "*", "/", "<", "<=", ">", ">=")
BITS = {"both": "&", "either": "|"}
BOOLEAN = ("<", "<=", ">", ">=", *BITS)
# As Python has them: the first argument unless the second is truly smaller, or larger.
TWICE = {"minimum": "<", "maximum": ">"}
# What needs no statement of its own.
READ = ("input", "value", "sum", "after")


class Writer:
    """Writes the statements of one C function.

    Args:
        real_name: name of the type in the code.
        floor: name of the function for it.
        tables: text of a constant -> expression of its place in a table.
        call: (node, name of the local, arguments) -> statement of a call.
        after: node of a number that a routine keeps -> expression of the place where the routine puts it.
    """

    def __init__(
        self,
        real: Real,
        real_name: str,
        floor: str,
        tables: Mapping[str, str] | None = None,
        call: Callable[[Node, str, list[str]], str] | None = None,
        after: Callable[[Node], str] | None = None,
    ) -> None:
        self._real = real
        self._real_name = real_name
        self._floor = floor
        self._tables = tables or {}
        self._call = call
        self._after = after
        # Expression of each node, and the origins of the constants that stand in it.
        self._written: dict[int, str] = {}
        self._origins: dict[int, list[str]] = {}

    def statements(self, targets: Sequence[tuple[str, Any]]) -> list[str]:
        """Return the statements that give each target its value: an expression that may be assigned to, or a declaration."""
        nodes = reachable([value for _, value in targets])
        uses = Counter(arg.order for node in nodes for arg in node.args if isinstance(arg, Node))
        uses.update(value.order for _, value in targets if isinstance(value, Node))
        # A minimum names its arguments twice.
        twice = {arg.order for node in nodes if node.op in TWICE for arg in node.args if isinstance(arg, Node)}
        lines: list[str] = []
        for node in nodes:
            if node.op not in READ:
                self._write(node, uses[node.order] > 1 or node.order in twice, lines)
        for target, value in targets:
            lines.append(_line(f"{target} = {_bare(self._expression(value))};", self._origins_in([value])))
        return lines

    def _write(self, node: Node, named: bool, lines: list[str]) -> None:
        origins = self._origins_in(node.args)
        if node.op == "call":
            assert self._call is not None
            text = f"{node.text[2]}_"
            lines.append(_line(self._call(node, text, [_bare(self._expression(arg)) for arg in node.args]), []))
        else:
            text = self._operation(node)
            if named or len(text) > LONGEST:
                kind = "int" if node.op in BOOLEAN else self._real_name
                name = f"v{len(self._written)}"
                lines.append(_line(f"const {kind} {name} = {_bare(text)};", origins))
                text, origins = name, []
            self._origins[node.order] = origins
        self._written[node.order] = text

    def _origins_in(self, values: Sequence[Any]) -> list[str]:
        texts: list[str] = []
        for value in values:
            if isinstance(value, Node):
                texts += self._origins.get(value.order, [])
            elif isinstance(value, Constant) and value.text not in self._tables and not _is_digits(value.text):
                texts.append(value.text)
        return list(dict.fromkeys(texts))

    def _expression(self, value: Any) -> str:
        if not isinstance(value, Node):
            return self._tables.get(text_of(value)) or literal(value, self._real)
        if value.op == "input":
            return value.text
        if value.op in ("value", "sum"):
            call = value.args[0]
            return self._written[call.order] + (f".{value.op}" if call.text[0] else "")
        if value.op == "after":
            assert self._after is not None, "the memory of a routine goes where the routine puts it"
            return self._after(value)
        return self._written[value.order]

    def _operation(self, node: Node) -> str:
        args = [self._expression(arg) for arg in node.args]
        op, suffix = node.op, self._real.suffix
        if op in INFIX:
            return f"({args[0]} {op} {args[1]})"
        if op in TWICE:
            return f"({args[1]} {TWICE[op]} {args[0]} ? {args[1]} : {args[0]})"
        if op == "select":
            return f"({args[0]} ? {args[1]} : {args[2]})"
        if op in BITS:
            return f"({args[0]} {BITS[op]} {args[1]})"
        if op == "neg":
            return f"(-{args[0]})"
        names = {"sqrt": f"sqrt{suffix}", "absolute": f"fabs{suffix}", "floor": self._floor}
        return f"{names[op]}({_bare(args[0])})"


def _line(code: str, origins: list[str]) -> str:
    """Return a statement with the origins of its constants, broken where it is long."""
    comment = f" /* {'; '.join(origins)} */" if origins else ""
    wrapper = TextWrapper(WIDTH, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    return "\n".join(wrapper.wrap(code + (comment if len(comment) <= LONGEST_COMMENT else "")))


def _is_digits(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _bare(text: str) -> str:
    """The expression without the parentheses around the whole of it."""
    if not text.startswith("("):
        return text
    depth = 0
    for place, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0:
            return text[1:-1] if place == len(text) - 1 and not text.startswith("(-") else text
    return text
