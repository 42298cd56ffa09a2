"""C text of graphs: literals that read back, and expressions that a compiler turns into the same bits."""

import ctypes
import subprocess

import numpy as np
import pytest

from plant.backends.c_code import DOUBLE, FLOAT, Writer, literal, rounded
from plant.backends.c_records import CRecords, snake
from plant.backends.tracing import Constant, Graph, rebinder
from plant.primitives import absolute, atan2, both, clip, either, floor, maximum, minimum, select, sign, sqrt
from plant.quadrotor.closed_loop import Limits
from plant.vectors import Quaternion, Rotors, Vec3
from tests.clients import program

FLOOR = """
static real whole_below(real x)
{
    real whole;
    if (!(fabs(x) < 4503599627370496.0))
        return x;
    whole = (real)(long long)x;
    return whole > x ? whole - 1.0 : whole;
}
"""
NUMBERS = [0.0, 1.0, 0.1, 1 / 3, 60.0, 1e-3, 123456.789, 9.81e-7, 3.4e38, 1.5e-38, 2.0**24 + 2.0, 1e-12]


@pytest.mark.parametrize("real", [FLOAT, DOUBLE], ids=["float", "double"])
@pytest.mark.parametrize("number", NUMBERS)
def test_a_literal_reads_back_as_the_same_bits(number, real):
    for value in (number, -number):
        text = literal(value, real)
        assert text.startswith("(-") == (np.copysign(1.0, value) < 0.0)
        bare = text.strip("()")
        assert bare.endswith("f") == (real is FLOAT)
        assert any(mark in bare for mark in ".e")
        assert real.dtype(bare.rstrip("f")).tobytes() == real.dtype(value).tobytes()


def test_what_guards_a_divisor_stays_above_zero():
    least = float(np.finfo(np.float32).tiny)
    assert rounded(1e-300, FLOAT) == least and rounded(-1e-300, FLOAT) == -least
    for real in (FLOAT, DOUBLE):
        assert (real.least, real.most) == (float(np.finfo(real.dtype).tiny), float(np.finfo(real.dtype).max))
    assert rounded(1e-300, DOUBLE) == 1e-300 and rounded(0.0, FLOAT) == 0.0
    with pytest.raises(AssertionError):
        rounded(1e300, FLOAT)


def mixed(a, b, k):
    near = either(both(a < b, a >= -1.0), b > 3.0)
    size = sqrt(absolute(a) + k * b * b)
    turned = atan2(a - 1e3 * b, b + 0.25) + floor(size * 7.5 - 20.0)
    limited = clip(turned, -k, 2.0) - minimum(a, -0.0) + maximum(0.0, b)
    return select(near, limited / (size + 1.0), -(a - b) - (a + b)), sign(a) * size, a - (b - k)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """`mixed` as a C function of two arrays of double."""
    folder = tmp_path_factory.mktemp("c")
    graph = Graph()
    results = rebinder()(mixed)(graph.input("a"), graph.input("b"), Constant(0.3, "k"))
    writer = Writer(DOUBLE, "real", "whole_below")
    lines = writer.statements([(f"out[{i}]", result) for i, result in enumerate(results)])
    text = "\n".join(lines)
    assert "/* k */" in text
    source = (
        f"#include <math.h>\ntypedef double real;\n{FLOOR}\nvoid mixed(real a, real b, real *out)\n{{\n{text}\n}}\n"
    )
    (folder / "mixed.c").write_text(source)
    flags = ("-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC")
    subprocess.run([program("gcc"), *flags, "mixed.c", "-o", "mixed.so", "-lm"], cwd=folder, check=True)
    function = ctypes.CDLL(str(folder / "mixed.so")).mixed
    function.argtypes = [ctypes.c_double, ctypes.c_double, ctypes.POINTER(ctypes.c_double)]
    return function


def test_compiled_statements_have_the_bits_of_the_function(compiled):
    from plant import primitives
    from plant.backends import vector_math
    from plant.backends.rebind import Rebinder

    names = {name: getattr(primitives, name) for name in primitives.__all__}
    plain = Rebinder(names | {"atan2": Rebinder(names)(vector_math.atan2)})(mixed)
    rng = np.random.default_rng(6)
    numbers = [*rng.standard_normal(2000).tolist(), 0.0, -0.0, 1.0, -1.0, 3.0]
    out = (ctypes.c_double * 3)()
    for a in numbers:
        b = float(rng.choice(numbers))
        compiled(a, b, out)
        assert np.array(out).tobytes() == np.array(plain(a, b, 0.3), dtype=float).tobytes(), (a, b)


def test_records_become_structures_in_the_order_of_their_fields():
    records = CRecords("p", {Vec3: "p_vec3"})
    assert records.name(Limits) == "p_limits"
    assert records.name(Vec3) == "p_vec3" and records.name(float) == "p_real"
    assert records.typedefs == ["typedef struct {\n    p_real position;\n    p_real cosine_tilt;\n} p_limits;"]
    assert records.name(Rotors) == "p_rotors" and len(records.typedefs) == 2
    assert records.name(Quaternion) == "p_quaternion"


def test_memories_are_told_apart_by_their_law():
    from plant.law_registry import law

    records = CRecords("p", {})
    assert records.name(law("pid").Memory) == "p_pid_memory"
    assert records.name(law("adrc").Memory) == "p_adrc_memory"
    assert records.name(law("hybrid").Memory) == "p_observer"
    assert snake("NonlinearObserverConstants") == "nonlinear_observer_constants"
