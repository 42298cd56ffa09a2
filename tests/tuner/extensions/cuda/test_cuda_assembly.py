"""The compiled kernel, without a card: it assembles for A100 and H100 within its registers, and is single where it says so."""

import re

import pytest

from plant.quadrotor.closed_loop import LARGEST_STATE
from tests.tuner.extensions.cuda.assembly import assembled, digits, innermost, missing, ptx, total
from tests.tuner.extensions.cuda.flights import PAIRS
from tuner.extensions.cuda.kernel import BLOCK, BLOCKS

pytestmark = pytest.mark.skipif(missing() is not None, reason=f"{missing()}")
ARCHITECTURES = ("sm_80", "sm_90")
# Bytes of local memory of a thread as first assembled (CUDA 13.0), a quarter more: 432 in single precision, 1640 in double.
LOCAL = {"float32": 540, "float64": 2050}
# The first compilation of a pair takes some 20 s, so only one is made by default.
CASES = [
    pytest.param(pair, precision, marks=() if (pair, precision) == (PAIRS[0], "float32") else pytest.mark.slow)
    for pair in PAIRS
    for precision in BLOCKS
]


@pytest.mark.parametrize(("pair", "precision"), CASES)
def test_kernel(pair, precision, tmp_path):
    text = ptx(*pair, precision)
    for architecture in ARCHITECTURES:
        used = assembled(text, architecture, tmp_path)
        assert used.registers * BLOCK * BLOCKS[precision] <= 65536
        assert used.local <= LOCAL[precision], (architecture, used)
    other = "f64" if precision == "float32" else "f32"
    # No number of the other precision, anywhere; double precision starts its quotients and roots from single estimates inside
    # ptxas, so PTX shows none of them either.
    assert not re.findall(rf"\.{other}\b", text)
    assert not re.findall(r"\bcall\b", text)
    step = innermost(text)
    # A Runge-Kutta step has four roots (airspeed), no division but h/6 and h/3, which ptxas takes out of the loop, and touches no
    # memory but arguments. 721 products and sums in single precision, some of them for all steps alike, of which 621 are left.
    assert total(step, "sqrt") == 4 and total(step, "div") <= 2
    assert total(step, "ld.global", "ld.local", "st") == 0
    assert 550 < total(step, "fma", "mul", "add", "sub") < 800
    # The size of the state against its limit: an ordered comparison taken as such, or its unordered opposite; never one that
    # a NaN would pass.
    limit = digits(LARGEST_STATE, precision)
    comparisons = set(re.findall(rf"setp\.(\w+)\.\S*\s+%p\d+, %fd?\d+, {limit};", text))
    assert comparisons and comparisons <= {"lt", "geu"}
