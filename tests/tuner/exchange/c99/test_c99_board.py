"""The exported C on a Cortex-M4F in QEMU: the bits of the host, and the instructions that a step may take."""

import pytest

from plant.law_registry import LAWS
from tests.tuner.exchange.c99.compiled import uneven
from tuner.exchange.c99.export import TARGET
from tuner.exchange.target import Request
from tuner.extensions.processor_cost import qemu
from tuner.extensions.processor_cost.measure import measure_cost

pytestmark = pytest.mark.skipif(bool(qemu.missing()), reason=f"{qemu.missing()} not installed; {qemu.REMEDY}")
# Instructions of the three attitude loops, call included: what hand-written code of these laws takes, and the refusal of NaN.
BUDGETS = {"pid": 200, "ladrc": 230, "hybrid": 320}


def same_bits(law, folder):
    controller = uneven(law, law)
    bundle = TARGET.export(Request(controller, "c" * 64, {"real": "float"}))
    sources = {name: text.decode() for name, text in bundle.files.items() if name.endswith((".c", ".h"))}
    return qemu.run_elf(qemu.build(sources, folder))


@pytest.mark.slow
@pytest.mark.parametrize("law", ["hybrid", *(pytest.param(law, marks=pytest.mark.slow) for law in ("pid", "adrc"))])
def test_golden_vectors_on_a_cortex_m4f(law, tmp_path):
    """The vectors are worked out here and compared there; the host passes the same ones in test_c99_bundle."""
    assert "the same bits: 200 steps of the cascade" in same_bits(law, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("law", sorted(set(LAWS) - {"pid", "hybrid", "adrc"}))
def test_golden_vectors_of_the_other_laws_on_a_cortex_m4f(law, tmp_path):
    assert "the same bits" in same_bits(law, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    "law", ["hybrid", *(pytest.param(law, marks=pytest.mark.slow) for law in BUDGETS if law != "hybrid")]
)
def test_instructions_of_the_attitude_loops(law):
    cost = measure_cost(uneven(law, law))
    assert cost.most_attitude <= BUDGETS[law]
