"""Routines: calls that differ by constants share a body; those whose constants choose another branch do not."""

from typing import NamedTuple

from plant.backends.tracing import Constant, Graph, reachable, rebinder, text_of
from plant.backends.tracing_routines import Routine
from plant.primitives import select, sqrt


class Gains(NamedTuple):
    """A gain and a mode."""

    k: float
    mode: float


class Memory(NamedTuple):
    """One number."""

    last: float


def loop(memory, constants, b, error, h):
    rate = select(constants.mode > 0.5, (error - memory.last) / h, error)
    return constants.k * b * rate, Memory(error)


def twice(memory, constants, b, left, right, h):
    u, _ = loop(memory, constants, b, left, h)
    v, _ = loop(memory, constants, b, right, h)
    return u + v


def routine(*gains, b=2.0):
    """A routine called once for each gains, with the same h."""
    made = Routine("loop", loop, Memory, watched=True)
    graph = Graph()
    for i, (k, mode) in enumerate(gains):
        constants = Gains(Constant(k, "constants.k"), Constant(mode, "constants.mode"))
        made.call(
            f"axis{i}", graph, graph.inputs(Memory, f"m{i}."), constants, b, graph.input(f"e{i}"), Constant(0.1, "h")
        )
    return made


def test_calls_share_one_body_with_a_table():
    (body,) = routine((3.0, 1.0), (5.0, 1.0)).bodies()
    assert body.parameters == ("error",)
    assert body.tables == {"constants.k * b": {"axis0": 6.0, "axis1": 10.0}}
    assert body.labels == ("axis0", "axis1")


def test_gains_that_happen_to_be_equal_stay_in_the_table():
    (body,) = routine((3.0, 1.0), (3.0, 1.0), (1.0, 1.0)).bodies()
    assert list(body.tables["constants.k * b"].values()) == [6.0, 6.0, 2.0]


def test_a_shared_one_of_the_source_drops_out_but_a_gain_of_one_does_not():
    (body,) = routine((3.0, 1.0), (1.0, 1.0), b=1.0).bodies()
    assert list(body.tables) == ["constants.k"]


def test_calls_whose_constants_choose_other_operations_have_bodies_of_their_own():
    bodies = routine((3.0, 1.0), (5.0, 0.0), (7.0, 1.0)).bodies()
    assert sorted(body.labels for body in bodies) == [("axis0", "axis2"), ("axis1",)]


def test_the_sum_tells_of_inputs_and_results():
    (body,) = routine((3.0, 1.0)).bodies()
    value, after, total = body.results
    assert after.text == "error"
    inside = {node.order for node in reachable([total])}
    assert value.order in inside and after.order in inside
    assert all(
        text_of(arg) != "constants.k" for node in reachable([total]) for arg in node.args if isinstance(arg, float)
    )


def test_a_call_stands_in_for_the_function():
    made = Routine("loop", loop, Memory, watched=True)
    graph = Graph()
    labels = iter(("left", "right"))
    bind = rebinder({loop: lambda *args: made.call(next(labels), graph, *args)})
    constants = Gains(Constant(3.0, "constants.k"), Constant(1.0, "constants.mode"))
    memory = graph.inputs(Memory, "m.")
    result = bind(twice)(memory, constants, 2.0, graph.input("l"), sqrt(4.0), Constant(0.1, "h"))
    assert [node.op for node in reachable([result])].count("call") == 2
    # Its third argument is a number in one call and a signal in the other, so it is a parameter.
    assert made.bodies()[0].parameters == ("error",)
    assert made.passed(made.calls[1].args) == [2.0]
