"""The entry points of a controller as graphs, with the three loops of each kind as calls of one routine."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from plant.backends import vector_math
from plant.backends.rebind import Rebinder
from plant.backends.tracing import Constant, Graph, rebinder
from plant.backends.tracing_finite import to_look_at
from plant.backends.tracing_routines import Routine
from plant.quadrotor.cascade import ATTITUDE_AXES, AXES, POSITION_AXES
from plant.quadrotor.nominal import Nominal, nominal
from plant.quadrotor.sensors import Measurement
from plant.records import flatten, pack, paths
from plant.references.track import Reference
from plant.vectors import Quaternion, Vec3
from tuner.exchange.c99.entries import (
    AttitudeApplied,
    AttitudeMeasurement,
    AttitudeSetpoint,
    Entries,
    commanded,
    entries,
    measurement_of,
)
from tuner.gains import Controller

# |q|^2 of a measured attitude may be off 1 by this much; beyond it is no attitude.
UNIT_WITHIN = 0.01


@dataclass(frozen=True)
class TracedFunction:
    """One traced function: (path of a result, value), and the sum that is finite only if all it takes and gives is."""

    results: tuple[tuple[str, Any], ...]
    sum: Any


@dataclass(frozen=True)
class Traces:
    """All entry points of a controller, and the routines that they call."""

    entries: Entries
    init: TracedFunction
    step: TracedFunction
    attitude_init: TracedFunction
    attitude_step: TracedFunction
    measure: TracedFunction
    position: Routine
    attitude: Routine
    atan2: Routine


def constants_of(controller: Controller) -> Any:
    """Constants of all loops, worked out in float64 by the laws' own `prepare`."""
    cascade = controller.cascade
    return cascade.prepare(pack(cascade.Gains, controller.gains), controller.control_period)


def nominal_of(controller: Controller) -> Nominal:
    """Nominal vehicle of the controller."""
    return nominal(controller.airframe.vehicle, controller.options, controller.control_period)


def trace(controller: Controller) -> Traces:
    """Trace all entry points."""
    bound = entries(controller.cascade)
    position, attitude = controller.cascade.position, controller.cascade.attitude
    outer = Routine("position_loop", position.step, position.Memory, watched=True)
    inner = Routine("attitude_loop", attitude.step, attitude.Memory, watched=True)
    angle = Routine("atan2", vector_math.atan2)
    constants, knowledge = named("constants", constants_of(controller)), named("", nominal_of(controller))
    h = Constant(controller.control_period, "h")

    def run(graph: Graph, function: Callable[..., Any], axes: tuple[str, ...], *arguments: Any) -> Any:
        return _bind(graph, controller, axes, outer, inner, angle)(function)(*arguments)

    g = Graph()
    m = g.inputs(Measurement, "m->")
    after = run(g, bound.init, (), constants, knowledge, m)
    init = traced(g, ("next.", after), ("next.command.", commanded(after.in_force, knowledge)))
    g = Graph()
    state, r, m = g.inputs(bound.State, "state->"), g.inputs(Reference, "reference->"), g.inputs(Measurement, "m->")
    command, after = run(g, bound.step, AXES, state, constants, knowledge, r, m, h)
    step = traced(g, ("next.command.", command), ("next.", after))
    g = Graph()
    am = g.inputs(AttitudeMeasurement, "m->")
    after = run(g, bound.attitude_init, (), constants, am)
    attitude_init = traced(g, ("next.", after), ("next.torque.", Vec3(0.0, 0.0, 0.0)))
    g = Graph()
    state, s = g.inputs(bound.AttitudeState, "state->"), g.inputs(AttitudeSetpoint, "setpoint->")
    am, applied = g.inputs(AttitudeMeasurement, "m->"), g.inputs(AttitudeApplied, "applied->")
    torque, after = run(g, bound.attitude_step, ATTITUDE_AXES, state, constants, knowledge, s, am, applied, h)
    attitude_step = traced(g, ("next.torque.", torque), ("next.", after))
    g = Graph()
    places, q = (
        [g.inputs(Vec3, f"{name}->") for name in ("position", "velocity", "rate")],
        g.inputs(Quaternion, "attitude->"),
    )
    measured = run(g, measurement_of, (), places[0], places[1], q, places[2])
    measure = traced(g, ("next.", measured))
    return Traces(bound, init, step, attitude_init, attitude_step, measure, outer, inner, angle)


def named(name: str, record: Any) -> Any:
    """Return a record of floats with each leaf knowing what it is called; constants of a loop are "constants.kp"."""
    kind = type(record)

    def text(path: str) -> str:
        return f"constants.{path.partition('.')[2]}" if name else path.removeprefix("vehicle.")

    return pack(kind, [Constant(value, text(path)) for path, value in zip(paths(kind), flatten(record), strict=True)])


def _bind(
    graph: Graph, controller: Controller, axes: tuple[str, ...], outer: Routine, inner: Routine, angle: Routine
) -> Rebinder:
    """Rebinder to a graph, with loops as calls in the order of the axes, and the arc tangent as a call."""
    order = iter(axes)

    def loop(*arguments: Any) -> Any:
        axis = next(order)
        return (outer if axis in POSITION_AXES else inner).call(axis, graph, *arguments)

    numbers: Iterator[int] = iter(range(1000))

    def atan2(y: Any, x: Any) -> Any:
        return angle.call(f"angle{next(numbers)}", graph, y, x)

    cascade = controller.cascade
    return rebinder({cascade.position.step: loop, cascade.attitude.step: loop, vector_math.atan2: atan2})


def traced(graph: Graph, *given: tuple[str, Any]) -> TracedFunction:
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
