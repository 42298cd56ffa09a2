"""Every function that model functions may use: on all backends, with the same numbers, and in the table for users."""

import inspect
import re
from pathlib import Path
from types import FunctionType
from typing import NamedTuple

import numpy as np
import pytest

from plant import primitives
from plant.backends import array, lanes, symbolic, tracing
from plant.backends.tracing import Graph, Node, reachable
from plant.primitives import (
    absolute,
    asin,
    atan2,
    both,
    clip,
    cos,
    either,
    exp,
    floor,
    hypot,
    log,
    maximum,
    minimum,
    select,
    sign,
    sin,
    sqrt,
    tan,
    tanh,
)
from plant.records import flatten

PAGE = (Path(__file__).parents[3] / "docs" / "model_functions.md").read_text(encoding="utf-8")
ROWS = dict(re.findall(r"^\| `(\w+)\(([\w, ]+)\)` \| .+ \|$", PAGE, re.MULTILINE))
"""Arguments of each function in the table of the page."""


class Every(NamedTuple):
    """A number of each primitive, by its name."""

    absolute: float
    asin: float
    atan2: float
    both: float
    clip: float
    cos: float
    either: float
    exp: float
    floor: float
    hypot: float
    log: float
    maximum: float
    minimum: float
    select: float
    sign: float
    sin: float
    sqrt: float
    tan: float
    tanh: float


def every(a, b):
    size = absolute(b) + 0.1
    return Every(
        absolute(a),
        asin(clip(a, -1.0, 1.0)),
        atan2(a, b),
        select(both(a > 0.0, b > 0.0), a, b),
        clip(a, -0.5, b * b),
        cos(a),
        select(either(a > 0.0, b > 0.0), a, b),
        exp(a),
        floor(a),
        hypot(a, b),
        log(size),
        maximum(a, b),
        minimum(a, b),
        select(a < b, a, -b),
        sign(a),
        sin(a),
        sqrt(size),
        tan(a),
        tanh(a),
    )


DRAW = np.random.default_rng(3)
PAIRS = [*DRAW.uniform(-3.0, 3.0, (40, 2)).tolist(), [1e-9, -1e-9], [-20.0, 300.0], [2.0, -0.0]]
WANTED = np.array([flatten(every(a, b)) for a, b in PAIRS])
RELATIVE, ABSOLUTE = 1e-12, 1e-14


def test_every_primitive_is_here():
    assert list(Every._fields) == sorted(primitives.__all__) == primitives.__all__


def test_arrays_give_the_numbers_of_python():
    a, b = np.array(PAIRS).T
    given = np.stack(flatten(array.rebinder()(every)(a, b)), axis=1)
    np.testing.assert_allclose(given, WANTED, rtol=RELATIVE, atol=ABSOLUTE)


def test_casadi_gives_the_numbers_of_python():
    expression = symbolic.symbolic_function("every", every, (float, float))
    np.testing.assert_allclose(
        [np.array(expression(a, b)).ravel() for a, b in PAIRS], WANTED, rtol=RELATIVE, atol=ABSOLUTE
    )


def test_compiled_lanes_give_the_numbers_of_python():
    native = lanes.compiled(every)
    np.testing.assert_allclose([flatten(native(a, b)) for a, b in PAIRS], WANTED, rtol=RELATIVE, atol=ABSOLUTE)


def of_signals(name):
    """A primitive traced on as many signals as the page gives it arguments."""
    letters = ", ".join("abc"[: len(ROWS[name].split(", "))])
    world = {"__name__": __name__, name: getattr(primitives, name)}
    graph = Graph()
    signals = [graph.input(letter) for letter in letters.split(", ")]
    return tracing.rebinder()(eval(f"lambda {letters}: {name}({letters})", world))(*signals)


@pytest.mark.parametrize("name", primitives.__all__)
def test_c_code_has_it_of_signals_or_refuses_it(name):
    if name in {"cos", "exp", "log", "sin", "tan", "tanh"}:
        with pytest.raises(TypeError, match=f"'{name}' of a signal has no code"):
            of_signals(name)
    else:
        assert isinstance(of_signals(name), Node)


def test_hypot_is_written_out_in_c_code():
    assert [node.op for node in reachable([of_signals("hypot")])][2:] == ["*", "*", "+", "sqrt"]


def test_the_page_on_plants_of_ones_own_has_every_primitive_with_its_arguments():
    assert sorted(ROWS) == primitives.__all__
    for name, arguments in ROWS.items():
        function = getattr(primitives, name)
        if isinstance(function, FunctionType):
            assert len(arguments.split(", ")) == len(inspect.signature(function).parameters), name
