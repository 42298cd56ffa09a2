"""A controller's C99 header and source, from its table of entry points."""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from plant.backends.c_code import REALS, Real, literal
from plant.backends.c_records import CRecords
from plant.backends.tracing import Graph, Node
from plant.backends.tracing_routines import Routine
from plant.quadrotor.gains import GainAddress
from plant.records import paths
from tuner.exchange.c99.routines import Style, function_of, function_text, loops
from tuner.exchange.c99.tracing import Results, TracedFunction, traced
from tuner.exchange.texts import c_comment, c_string, filled, tool

# Ways to work out floating point that keep every operation of a type in it; 16 differs from 0 in half precision alone.
EVALUATION = {
    "float": "FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16",
    "double": "FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 1 && FLT_EVAL_METHOD != 16",
}
REFUSE = """\
if (!(sum - sum == {zero})) {{ /* infinite or NaN: something that came in or would go out is */
{refused}    return {P}_REFUSED;
}}"""


@dataclass(frozen=True)
class Code:
    """C99 of a controller.

    Attributes:
        header: Text of NAME.h.
        source: Text of NAME.c.
        name: Stem of both.
        types: C names of records, by the words of the templates.
    """

    header: str
    source: str
    name: str
    types: dict[str, str]


Instant = tuple[tuple[Any, ...], tuple[Any, ...], tuple[Any, ...]]
"""Records that an entry point takes, gives and then keeps."""
Flight = Callable[[Real, int], Iterator[Instant]]
"""A flight in a precision: first the instant of init, with what a refused step would give behind what it keeps."""


@dataclass(frozen=True)
class Entry:
    """An entry point.

    Attributes:
        name: Name in C, behind the prefix.
        work: Return what a graph and its inputs result in.
        takes: Types of what it takes, by name.
        output: Name and type of what it gives besides the state, None where that is nothing.
        state: Type of the state, None where it fills its output alone.
        memory: Code of the members of the state that the loops keep.
        guard: Return lines of C in front of all others.
        flight: A closed loop of so many steps, for golden vectors.
    """

    name: str
    work: Callable[..., Results]
    takes: Mapping[str, Any]
    output: tuple[str, Any] | None = None
    state: Any = None
    memory: str = ""
    guard: Callable[[Style], list[str]] = lambda _: []
    flight: Flight | None = None

    def trace(self) -> TracedFunction:
        """Return its graph."""
        graph = Graph()
        # An init only fills the state.
        read = {"state": self.state} if self.state is not None and self.output is not None else {}
        given = [graph.inputs(kind, f"{name}->") for name, kind in {**read, **self.takes}.items()]
        return traced(graph, self.work(graph, *given))


@dataclass(frozen=True)
class Program:
    """A controller of any kind as a table.

    Attributes:
        title: Title of what it controls.
        period: Control period [s].
        entries: Entry points.
        routines: Loops that they call.
        gains: Gains as text, by axis or channel and name.
        declared: Names of records that the header declares by itself, and names that no record may take.
        types: Other records, by the words of the templates.
        words: Other words of the header.
        numbers: Words of the header that are numbers.
        helpers: Routines that keep nothing.
        templates: Prefix of the names of its templates.
        table: Suffix of the names of tables of gains.
        note: Return the comment behind a member of a record.
    """

    title: str
    period: float
    entries: tuple[Entry, ...]
    routines: tuple[Routine, ...]
    gains: Mapping[str, Mapping[str, str]]
    declared: Mapping[Any, str]
    types: Mapping[str, Any]
    words: Mapping[str, str]
    numbers: Mapping[str, float] = field(default_factory=dict)
    helpers: tuple[Routine, ...] = ()
    templates: str = ""
    table: str = ""
    note: Callable[[Any], str] = lambda _: ""


def digest_of(gains: Sequence[float]) -> str:
    """Return the digest of the gains' bits; for gains that come from no file."""
    return hashlib.sha256(" ".join(gain.hex() for gain in gains).encode()).hexdigest()


def write_code(program: Program, real: str, prefix: str, digest: str) -> Code:
    """Write a controller in C99.

    Args:
        program: The controller.
        real: Type of all numbers, "float" or "double".
        prefix: Prefix in front of all names, a C identifier in lower case.
        digest: Digest of the gains.
    """
    assert prefix.isidentifier() and prefix.islower(), prefix
    records = CRecords(prefix, {kind: f"{prefix}_{name}" for kind, name in program.declared.items()}, program.note)
    style = Style(REALS[real], prefix, records, program.table)
    types = {word: records.name(kind) for word, kind in program.types.items()}
    return Code(_header(program, style, digest, types), _source(program, style), f"{prefix}_controller", types)


def _header(program: Program, style: Style, digest: str, types: Mapping[str, str]) -> str:
    kind = style.real
    numbers = {"period_literal": program.period, **program.numbers}
    return filled(
        "tuner.exchange.c99",
        f"{program.templates}controller.h",
        p=style.prefix,
        P=style.prefix.upper(),
        tool=tool(),
        title=c_comment(program.title),
        period=f"{program.period:.9g}",
        real=kind.name,
        suffix=kind.suffix,
        digest=c_comment(digest),
        digest_text=c_string(digest),
        typedefs="\n\n".join(style.records.typedefs),
        **{name: literal(value, kind) for name, value in numbers.items()},
        **program.words,
        **types,
    )


def _source(program: Program, style: Style) -> str:
    p, real = style.prefix, style.real
    # Loops are those that were called while their entry points were traced.
    traced_entries = [(entry, entry.trace()) for entry in program.entries]
    written = {routine.name: loops(routine, style, program.gains) for routine in program.routines}
    memories = {routine.name: paths(routine.memory) for routine in program.routines}

    def write(entry: Entry, function: TracedFunction) -> str:
        def call(node: Node, local: str, args: list[str]) -> str:
            if node.text[1] in written:
                return written[node.text[1]].call(entry.memory)(node, local, args)
            return f"const {p}_real {local} = {p}_{node.text[1]}({', '.join(args)});"

        def after(node: Node) -> str:
            call, number = node.args
            return f"next.{entry.memory}{call.text[2]}.{memories[call.text[1]][int(number)]}"

        lines = [(_place(path), value) for path, value in function.results]
        total = (f"const {p}_real sum", function.sum)
        return entry_function(style, entry, style.writer(None, call, after).statements([*lines, total]))

    functions = [write(entry, function) for entry, function in traced_entries]
    text = "\n\n".join([*(each.text for each in written.values()), *functions])
    helpers = [function_of(each, style) for each in program.helpers]
    words = {"p": p, "P": p.upper(), "real": real.name, "suffix": real.suffix}
    if f"{p}_floor(" in "".join([text, *helpers]):
        largest, one = literal(real.largest_fraction, real), literal(1.0, real)
        floor = filled("tuner.exchange.c99", "floor.c", **words, largest=largest, whole=real.integer_type, one=one)
        helpers = [floor.rstrip(), *helpers]
    return filled(
        "tuner.exchange.c99",
        "controller.c",
        **words,
        title=c_comment(program.title),
        tool=tool(),
        evaluation=EVALUATION[real.name],
        helpers="".join(f"{helper}\n\n" for helper in helpers),
        functions=text,
    )


def gain_texts(gains: Sequence[GainAddress], row: Sequence[float]) -> dict[str, dict[str, str]]:
    """Return each gain's value with unit, by axis or channel and name."""
    texts: dict[str, dict[str, str]] = {}
    for gain in gains:
        name = gain.address.partition(".")[2]
        texts.setdefault(gain.axis, {})[name] = f"{row[gain.column]:.9g} {c_comment(gain.unit)}"
    return texts


def entry_function(style: Style, entry: Entry, lines: list[str]) -> str:
    """Write an entry point: what it works out goes into `next`, and from there on only if all of it is finite."""
    p, name = style.prefix, style.records.name
    states = {} if entry.state is None else {"state": entry.state}
    given = {} if entry.output is None else dict((entry.output,))
    (filled_name, kind), *others = {**states, **given}.items()
    refused = "".join(f"    *{output} = state->{output};\n" for output, _ in others)
    body = [
        f"{name(kind)} next;",
        *entry.guard(style),
        *lines,
        REFUSE.format(zero=literal(0.0, style.real), refused=refused, P=p.upper()),
        f"*{filled_name} = next;",
        *[f"*{output} = next.{output};" for output, _ in others],
        f"return {p.upper()}_OK;",
    ]
    parameters = [
        *[f"{name(kind)} *{each}" for each, kind in states.items()],
        *[f"const {name(kind)} *{each}" for each, kind in entry.takes.items()],
        *[f"{name(kind)} *{each}" for each, kind in given.items()],
    ]
    return function_text(f"{p}_status {p}_{entry.name}", parameters, body)


def _place(path: str) -> str:
    """Name of a result in C: rotors of a command are an array."""
    for i in range(4):
        path = path.replace(f"command.rotor_thrust.r{i + 1}", f"command.rotor_thrust[{i}]")
    return path
