"""Traced graphs, evaluated by hand: same values as the function, constants gone, one branch of a constant choice."""

import math

import pytest

from plant.backends.rebind import Rebinder
from plant.backends.tracing import Constant, Graph, Node, reachable, rebinder, text_of
from plant.primitives import absolute, atan2, both, clip, cos, either, floor, maximum, minimum, select, sign, sqrt
from plant.vectors import Vec3

OPERATIONS = {
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b,
    "neg": lambda a: -a, "<": lambda a, b: a < b, "<=": lambda a, b: a <= b, ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b, "both": lambda a, b: a and b, "either": lambda a, b: a or b,
    "sqrt": math.sqrt, "absolute": abs, "floor": math.floor, "minimum": lambda a, b: b if b < a else a,
    "maximum": lambda a, b: b if b > a else a, "select": lambda c, a, b: a if c else b,
}  # fmt: skip


def value(result, inputs):
    """Value of a traced result for values of its inputs."""
    found = {}
    for node in reachable([result]):
        arguments = [found[arg.order] if isinstance(arg, Node) else float(arg) for arg in node.args]
        found[node.order] = inputs[node.text] if node.op == "input" else OPERATIONS[node.op](*arguments)
    return found[result.order] if isinstance(result, Node) else float(result)


def traced(function, *names, stand_ins=None):
    graph = Graph()
    return rebinder(stand_ins)(function)(*[graph.input(name) for name in names])


def operations(result):
    return [node.op for node in reachable([result]) if node.op != "input"]


def everything(a, b):
    inside = both(a > -1.0, either(b < 2.0, a >= b))
    turned = atan2(a, b) + floor(a / b + 0.5)
    return select(inside, maximum(a, b) * sqrt(absolute(a)), clip(turned, -1.0, 1.0) - sign(b)) + minimum(2.0 * a, -b)


@pytest.mark.parametrize("a", [-3.0, -0.7, 0.0, 0.4, 5.0])
@pytest.mark.parametrize("b", [-2.5, -0.1, 0.3, 4.0])
def test_a_graph_has_the_value_of_its_function(a, b):
    result = traced(everything, "a", "b")
    assert value(result, {"a": a, "b": b}) == pytest.approx(everything(a, b), abs=1e-15)


def order(a, b, c):
    return a + b + c, a + (b + c)


def test_the_order_of_the_source_is_kept():
    left, right = traced(order, "a", "b", "c")
    big = {"a": 1.0, "b": 1e16, "c": -1e16}
    assert value(left, big) == 0.0 and value(right, big) == 1.0


def shared(a, b):
    return sqrt(a * b) + sqrt(a * b)


def test_the_same_operation_is_one_node():
    assert operations(traced(shared, "a", "b")) == ["*", "sqrt", "+"]


def gains(a, k, mode):
    return select(mode > 0.5, k * 0.5 * a, sqrt(-a)) / (1.0 + k)


def test_what_depends_on_constants_alone_is_worked_out():
    graph = Graph()
    result = rebinder()(gains)(graph.input("a"), Constant(0.1, "k"), Constant(1.0, "mode"))
    assert operations(result) == ["*", "/"]
    product, divisor = result.args
    assert float(divisor) == 1.0 + 0.1 and text_of(divisor) == "1.0 + k"
    assert float(product.args[0]) == 0.1 * 0.5 and text_of(product.args[0]) == "k * 0.5"
    assert value(result, {"a": -3.0}) == gains(-3.0, 0.1, 1.0)
    assert operations(rebinder()(gains)(graph.input("a"), 0.1, 0.0)) == ["neg", "sqrt", "/"]


def test_texts_of_constants_read_as_they_are_worked_out():
    h, k, b = Constant(0.1, "h"), Constant(3.0, "k"), Constant(2.0, "b")
    scope = {"h": 0.1, "k": 3.0, "b": 2.0}
    for made in (
        h * k * b,
        h * (k * b),
        (h + k) * b,
        h - (k - b),
        (h - k) - b,
        h / (k * b),
        -(h + k),
        1.0 - h * k,
        0.5 * h,
    ):
        assert eval(text_of(made), {}, scope) == float(made), text_of(made)


def idle(a):
    return a * 1.0 / 1.0 - 0.0, a + 0.0


def test_only_what_changes_no_bit_is_left_out():
    same, added = traced(idle, "a")
    assert same.op == "input"
    # -0.0 + 0.0 is 0.0, so the addition stays.
    assert operations(added) == ["+"]
    graph = Graph()
    kept = graph.input("a") * Constant(1.0, "constants.k")
    assert kept.op == "*"


def of_records(v):
    return v.x * v.y + v.z


def test_records_are_traced_by_the_path_of_their_leaves():
    graph = Graph()
    result = rebinder()(of_records)(graph.inputs(Vec3, "m->"))
    assert [node.text for node in reachable([result]) if node.op == "input"] == ["m->x", "m->y", "m->z"]


def branching(a):
    return a if a > 0.0 else -a


def equal(a):
    return select(a == 0.0, 1.0, a)


def turning(a):
    return cos(a)


@pytest.mark.parametrize(("function", "words"), [(branching, "select"), (equal, "<, <="), (turning, "'cos'")])
def test_what_has_no_code_is_refused(function, words):
    with pytest.raises(TypeError, match=words):
        traced(function, "a")


def test_constants_may_be_turned():
    assert rebinder()(turning)(Constant(0.3, "a")) == math.cos(0.3)


def test_a_stand_in_takes_the_place_of_a_function():
    result = traced(shared_twice, "a", stand_ins={shared: lambda a, b: a - b})
    assert operations(result) == ["-", "+"]


def shared_twice(a):
    return shared(a, 2.0) + a


def test_the_rebinder_is_the_common_one():
    assert isinstance(rebinder(), Rebinder)
