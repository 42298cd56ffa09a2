"""Whatever makes one of the values infinite or NaN shows in those that are looked at: tried on random graphs."""

import warnings

import numpy as np
import pytest

from plant.backends.tracing import Graph, Node, reachable
from plant.backends.tracing_finite import to_look_at

BINARY = ("+", "-", "*", "/", "minimum", "maximum")
UNARY = ("neg", "sqrt", "absolute", "floor")
NUMPY = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "neg": np.negative, "sqrt": np.sqrt,
    "absolute": np.abs, "floor": np.floor, "minimum": lambda a, b: np.where(b < a, b, a),
    "maximum": lambda a, b: np.where(b > a, b, a), "select": lambda a, b, c: np.where(a > 0.0, b, c),
}  # fmt: skip


def grown(rng, size=30):
    """A random graph of five inputs."""
    graph = Graph()
    nodes = [graph.input(f"i{k}") for k in range(5)]
    while len(nodes) < size:
        a, b, c = (nodes[i] for i in rng.integers(0, len(nodes), 3))
        kind = rng.integers(0, 10)
        if kind < 6:
            node = graph.node(str(rng.choice(BINARY)), a, b)
        elif kind < 9:
            node = graph.node(str(rng.choice(UNARY)), a)
        else:
            node = graph.node("select", a, b, c)
        nodes.append(node)
    return nodes


def values_of(nodes, inputs):
    found = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for node in reachable(nodes):
            arguments = [found[arg.order] for arg in node.args]
            found[node.order] = inputs[int(node.text[1:])] if node.op == "input" else NUMPY[node.op](*arguments)
    return found


@pytest.mark.parametrize("seed", range(60))
def test_nothing_that_is_not_finite_goes_unnoticed(seed):
    rng = np.random.default_rng(seed)
    nodes = grown(rng)
    wanted = [nodes[i] for i in rng.integers(0, len(nodes), 8)] + nodes[:5]
    looked_at = to_look_at(wanted)
    inputs = rng.standard_normal((5, 400)) * 10.0 ** rng.integers(-30, 30, (5, 400))
    inputs = np.where(rng.random((5, 400)) < 0.05, rng.choice([np.nan, np.inf, -np.inf, 1e308, 0.0], (5, 400)), inputs)
    found = values_of(nodes, inputs)
    seen = np.array([np.isfinite(found[node.order]) for node in looked_at]).all(axis=0)
    all_of_them = np.array([np.isfinite(found[node.order]) for node in wanted]).all(axis=0)
    assert (seen == all_of_them).all()


def test_what_flows_on_by_sums_and_products_is_not_looked_at():
    graph = Graph()
    a, b, c = (graph.input(name) for name in "abc")
    total = graph.node("/", graph.node("+", a, b), c)
    assert [node.text or node.op for node in to_look_at([a, b, c, total])] == ["c", "/"]
    limited = graph.node("minimum", a, 1.0)
    assert {node.order for node in to_look_at([a, limited])} == {a.order, limited.order}


def test_a_value_that_stands_for_itself_is_looked_at_once():
    graph = Graph()
    a = graph.input("a")
    assert to_look_at([a, a, 1.0]) == [a]
    assert isinstance(a, Node)
