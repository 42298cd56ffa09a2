"""The loops of a controller as static C functions; the constants of each loop are a table."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from textwrap import indent, wrap

from plant.backends.c_code import Real, Writer, literal
from plant.backends.c_records import CRecords
from plant.backends.tracing import Node
from plant.backends.tracing_routines import Routine, SharedRoutine
from plant.records import paths

LONGEST_FIELD = 28
Call = Callable[[Node, str, list[str]], str]
After = Callable[[Node], str]


@dataclass(frozen=True)
class Style:
    """Style of all C of a controller: its floating-point type, the prefix of its names and the types of its records.

    table: behind the name of an axis in that of its table.
    """

    real: Real
    prefix: str
    records: CRecords
    table: str = ""

    def writer(
        self, tables: Mapping[str, str] | None = None, call: Call | None = None, after: After | None = None
    ) -> Writer:
        """Return a writer of statements."""
        return Writer(self.real, f"{self.prefix}_real", f"{self.prefix}_floor", tables, call, after)


@dataclass(frozen=True)
class Loops:
    """Loops of one kind in C. text: tables and functions; call(memory): what a `Writer` writes for a call of one of them,
    where state->memory.AXIS is what the loop of that axis keeps.
    """

    text: str
    call: Callable[[str], Call]


def loops(routine: Routine, style: Style, gains: Mapping[str, Mapping[str, str]]) -> Loops:
    """Write the loops of a routine; gains: axis -> gain -> "6 rad/s"."""
    bodies = routine.bodies()
    parts: list[str] = []
    served: dict[str, tuple[str, bool]] = {}
    for i, body in enumerate(bodies):
        name = f"{style.prefix}_{routine.name}" + (f"_{i + 1}" if len(bodies) > 1 else "")
        fields = _fields(body)
        parts += [*_tables(name, body, fields, style, gains), _function(name, body, fields, routine, style)]
        served.update({axis: (name, bool(fields)) for axis in body.labels})

    def caller(memory: str) -> Call:
        def call(node: Node, local: str, args: list[str]) -> str:
            axis = node.text[2]
            name, tabled = served[axis]
            table = [f"&{style.prefix}_{axis}{style.table}"] if tabled else []
            given = ", ".join([f"&state->{memory}{axis}", f"&next.{memory}{axis}", *table, *routine.passed(args)])
            return f"const {style.prefix}_loop {local} = {name}({given});"

        return call

    return Loops("\n\n".join(parts), caller)


def _fields(body: SharedRoutine) -> dict[str, str]:
    """Return the table's member for each constant, named after constant or origin."""
    fields: dict[str, str] = {}
    for text in body.tables:
        plain = re.sub(r"\W+", "_", _origin(text)).strip("_").lower()
        if len(plain) > LONGEST_FIELD or not plain[0].isalpha() or plain in fields.values():
            plain = f"c{len(fields) + 1}"
        fields[text] = plain
    return fields


def _origin(text: str) -> str:
    return text.replace("constants.", "").replace("channel.", "")


def _tables(
    name: str, body: SharedRoutine, fields: Mapping[str, str], style: Style, gains: Mapping[str, Mapping[str, str]]
) -> list[str]:
    if not fields:
        return []
    members = "\n".join(f"    {style.prefix}_real {field};" for field in fields.values())
    parts = [f"typedef struct {{\n{members}\n}} {name}_constants;"]
    for axis in body.labels:
        given = ", ".join(f"{axis}.{gain} = {value}" for gain, value in gains[axis].items())
        lines = [
            f"    {literal(body.tables[text][axis], style.real).strip('()')}, /* {_comment(axis, text, gains)} */"
            for text in fields
        ]
        opening = f"/* {given} */\nstatic const {name}_constants {style.prefix}_{axis}{style.table} = {{"
        parts.append("\n".join([opening, *lines, "};"]))
    return parts


def _comment(axis: str, text: str, gains: Mapping[str, Mapping[str, str]]) -> str:
    origin = _origin(text)
    value = gains[axis].get(origin.rstrip("_"))
    return origin if value is None else f"{axis}.{origin.rstrip('_')} [{value.partition(' ')[2]}]"


def _function(name: str, body: SharedRoutine, fields: Mapping[str, str], routine: Routine, style: Style) -> str:
    real, memory = f"{style.prefix}_real", style.records.name(routine.memory)
    value, *after, total = body.results
    targets = [(f"next->{path}", leaf) for path, leaf in zip(paths(routine.memory), after, strict=True)]
    targets += [("result.value", value), ("result.sum", total)]
    lines = style.writer({text: f"c->{field}" for text, field in fields.items()}).statements(targets)
    restrict = f"{style.prefix.upper()}_RESTRICT"
    taken = [f"const {memory} *{restrict} m", f"{memory} *{restrict} next"]
    taken += [f"const {name}_constants *{restrict} c"] if fields else []
    taken += [f"{real} {parameter}" for parameter in body.parameters]
    return function_text(
        f"static inline {style.prefix}_loop {name}", taken, [f"{style.prefix}_loop result;", *lines, "return result;"]
    )


def function_of(routine: Routine, style: Style) -> str:
    """Write a routine that keeps nothing and takes no constants: an arc tangent."""
    (body,) = routine.bodies()
    lines = style.writer().statements([(f"const {style.prefix}_real result", body.results[0])])
    taken = [f"{style.prefix}_real {parameter}" for parameter in body.parameters]
    return function_text(f"static {style.prefix}_real {style.prefix}_{routine.name}", taken, [*lines, "return result;"])


def function_text(name: str, parameters: list[str], lines: list[str]) -> str:
    """Return the text of a function: type and name, parameters, lines of its body."""
    opening = "\n".join(wrap(f"{name}({', '.join(parameters)})", 116, subsequent_indent="    "))
    return f"{opening}\n{{\n{indent(chr(10).join(lines), '    ')}\n}}"
