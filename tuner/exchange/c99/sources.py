"""The controller as one C99 header and one C99 source, traced from the model functions that the simulator flies."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

from plant.backends.c_code import REALS, literal
from plant.backends.c_records import CRecords
from plant.backends.tracing import Node
from plant.quadrotor.gains import GainAddress, gain_addresses
from plant.quadrotor.sensors import Measurement
from plant.references.track import Reference
from plant.vectors import Quaternion, Rotors, Vec3
from tuner.exchange.c99.entries import AttitudeApplied, AttitudeMeasurement, AttitudeSetpoint, Command
from tuner.exchange.c99.routines import After, Call, Style, function_of, function_text, loops
from tuner.exchange.c99.tracing import UNIT_WITHIN, TracedFunction, Traces, trace
from tuner.exchange.texts import c_comment, c_string, filled, tool
from tuner.gains import Controller

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
    """C99 of a controller. header, source: texts of NAME.h and NAME.c; name: their stem."""

    header: str
    source: str
    name: str


@dataclass(frozen=True)
class CSources(Code):
    """C99 of a quadrotor's controller; traces: the graphs that it was written from."""

    traces: Traces


def digest_of(gains: Sequence[float]) -> str:
    """Return the digest of the gains' bits, for gains that come from no file."""
    return hashlib.sha256(" ".join(gain.hex() for gain in gains).encode()).hexdigest()


def c_sources(controller: Controller, real: str = "float", prefix: str = "holdfast", digest: str = "") -> CSources:
    """Write the controller in C99.

    real: "float" or "double", the type of all numbers. prefix: of all names, a C identifier in lower case; the files are
    PREFIX_controller.h and .c. digest: of the gains.json that the gains come from, `digest_of` where there is none.
    """
    assert prefix.isidentifier() and prefix.islower(), prefix
    traces = trace(controller)
    given = {
        Vec3: "vec3",
        Reference: "reference",
        Measurement: "measurement",
        Command: "command",
        Quaternion: "quaternion",
        AttitudeSetpoint: "attitude_setpoint",
        AttitudeMeasurement: "attitude_measurement",
        AttitudeApplied: "attitude_applied",
    }
    records = CRecords(prefix, {kind: f"{prefix}_{name}" for kind, name in given.items()})
    style = Style(REALS[real], prefix, records)
    for kind in (controller.cascade.Memory, Rotors, controller.cascade.attitude.Memory):
        records.name(kind)
    header = _header(controller, style, digest or digest_of(controller.gains))
    return CSources(header, _source(controller, traces, style), f"{prefix}_controller", traces)


def _header(controller: Controller, style: Style, digest: str) -> str:
    """Write the header; the types of all states are among the records of the style."""
    cascade, kind, records = controller.cascade, style.real, style.records
    return filled(
        "c99",
        "controller.h",
        p=style.prefix,
        P=style.prefix.upper(),
        tool=tool(),
        title=c_comment(controller.airframe.title),
        airframe=c_comment(controller.airframe.name),
        position=cascade.position.name,
        attitude=cascade.attitude.name,
        period=f"{controller.control_period:.9g}",
        period_literal=literal(controller.control_period, kind),
        mass=literal(controller.airframe.vehicle.mass, kind),
        real=kind.name,
        suffix=kind.suffix,
        digest=c_comment(digest),
        airframe_text=c_string(controller.airframe.name),
        digest_text=c_string(digest),
        typedefs="\n\n".join(records.typedefs),
        memory=records.name(cascade.Memory),
        loop_memory=records.name(cascade.attitude.Memory),
    )


def _source(controller: Controller, traces: Traces, style: Style) -> str:
    p = style.prefix
    gains = gain_texts(gain_addresses(controller.cascade), controller.gains)
    outer, inner = loops(traces.position, style, gains), loops(traces.attitude, style, gains)

    def call_cascade(node: Node, local: str, args: list[str]) -> str:
        if node.text[1] == "atan2":
            return f"const {p}_real {local} = {p}_atan2({', '.join(args)});"
        kind = outer if node.text[1] == traces.position.name else inner
        return kind.call("control.")(node, local, args)

    functions = [
        outer.text,
        inner.text,
        entry_function(style, "init", traces.init, [f"{p}_state *state", f"const {p}_measurement *m"], "state", None),
        entry_function(
            style,
            "step",
            traces.step,
            [
                f"{p}_state *state",
                f"const {p}_reference *reference",
                f"const {p}_measurement *m",
                f"{p}_command *command",
            ],
            "state",
            call_cascade,
            "command",
        ),
        entry_function(
            style,
            "attitude_init",
            traces.attitude_init,
            [f"{p}_attitude_state *state", f"const {p}_attitude_measurement *m"],
            "attitude_state",
            None,
        ),
        entry_function(
            style,
            "attitude_step",
            traces.attitude_step,
            [
                f"{p}_attitude_state *state",
                f"const {p}_attitude_setpoint *setpoint",
                f"const {p}_attitude_measurement *m",
                f"const {p}_attitude_applied *applied",
                f"{p}_vec3 *torque",
            ],
            "attitude_state",
            inner.call(""),
            "torque",
        ),
        _measure(style, traces.measure, call_cascade),
    ]
    return source_text(style, controller.airframe.title, functions, [function_of(traces.atan2, style)])


def source_text(style: Style, title: str, functions: list[str], helpers: Sequence[str] = ()) -> str:
    """Write the source around its functions; title: of what it controls; helpers: functions that they call."""
    p, real = style.prefix, style.real
    words = {"p": p, "P": p.upper(), "real": real.name, "suffix": real.suffix}
    text = "\n\n".join(functions)
    if f"{p}_floor(" in "".join([text, *helpers]):
        largest, one = literal(real.largest_fraction, real), literal(1.0, real)
        floor = filled("c99", "floor.c", **words, largest=largest, whole=real.integer_type, one=one)
        helpers = [floor.rstrip(), *helpers]
    return filled(
        "c99",
        "controller.c",
        **words,
        title=c_comment(title),
        tool=tool(),
        evaluation=EVALUATION[real.name],
        helpers="".join(f"{helper}\n\n" for helper in helpers),
        functions=text,
    )


def gain_texts(gains: Sequence[GainAddress], row: Sequence[float]) -> dict[str, dict[str, str]]:
    """Return value with unit of each gain, by axis or channel and name."""
    texts: dict[str, dict[str, str]] = {}
    for gain in gains:
        name = gain.address.partition(".")[2]
        texts.setdefault(gain.axis, {})[name] = f"{row[gain.column]:.9g} {c_comment(gain.unit)}"
    return texts


def entry_function(
    style: Style,
    name: str,
    entry: TracedFunction,
    parameters: list[str],
    kind: str,
    call: Call | None,
    output: str = "",
    after: After | None = None,
) -> str:
    """Write an entry point: what it works out goes into `next`, and from there into the state only if all of it is finite."""
    p = style.prefix
    targets = [(_place(path), value) for path, value in entry.results]
    lines = style.writer(None, call, after).statements([*targets, (f"const {p}_real sum", entry.sum)])
    refused = f"    *{output} = state->{output};\n" if output else ""
    check = REFUSE.format(zero=literal(0.0, style.real), refused=refused, P=p.upper())
    done = [f"*{output} = next.{output};"] if output else []
    body = [f"{p}_{kind} next;", *lines, check, "*state = next;", *done, f"return {p.upper()}_OK;"]
    return function_text(f"{p}_status {p}_{name}", parameters, body)


def _place(path: str) -> str:
    """Name of a result in C: rotors of a command are an array."""
    for i in range(4):
        path = path.replace(f"command.rotor_thrust.r{i + 1}", f"command.rotor_thrust[{i}]")
    return path


def _measure(style: Style, entry: TracedFunction, call: Call) -> str:
    p = style.prefix
    lines = style.writer(call=call).statements([*entry.results, (f"const {p}_real sum", entry.sum)])
    q = "attitude->"
    square = f"{q}w * {q}w + {q}x * {q}x + {q}y * {q}y + {q}z * {q}z"
    low, high = literal(1.0 - UNIT_WITHIN, style.real), literal(1.0 + UNIT_WITHIN, style.real)
    body = [
        f"{p}_measurement next;",
        f"const {p}_real square = {square};",
        f"if (!(square > {low} && square < {high})) /* no attitude, or NaN */",
        f"    return {p.upper()}_REFUSED;",
        *lines,
        REFUSE.format(zero=literal(0.0, style.real), refused="", P=p.upper()),
        "*m = next;",
        f"return {p.upper()}_OK;",
    ]
    taken = (f"const {p}_vec3 *position", f"const {p}_vec3 *velocity", f"const {p}_quaternion *attitude")
    return function_text(f"{p}_status {p}_measure", [*taken, f"const {p}_vec3 *rate", f"{p}_measurement *m"], body)
