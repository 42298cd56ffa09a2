"""The counting itself, on programs whose counts are known without running them."""

import numpy as np
import pytest

from plant.errors import InputError
from tests.clients import program
from tuner.extensions.processor_cost import qemu
from tuner.extensions.processor_cost.measure import deepest_stack, flash_bytes

COUNTING = """\
#include <stdio.h>
#include "ticks.h"

static unsigned empty;

static unsigned loop(unsigned times)
{
    const unsigned before = ticks_now();
    __asm volatile("1: subs %0, #1\\n bne 1b" : "+r"(times) :: "cc");
    return instructions(ticks_between(before, ticks_now()), empty);
}

static unsigned divisions(void)
{
    const unsigned before = ticks_now();
    __asm volatile("vdiv.f32 s0, s1, s2\\n vsqrt.f32 s0, s1\\n nop" ::: "s0");
    return instructions(ticks_between(before, ticks_now()), empty);
}

int main(void)
{
    unsigned before;
    ticks_start();
    before = ticks_now();
    empty = ticks_between(before, ticks_now());
    printf("%u %u %u %u %u\\n", loop(1), loop(2), loop(1000), loop(300000), divisions());
    return 0;
}
"""


@pytest.fixture(autouse=True)
def toolchain():
    program("arm-none-eabi-gcc")
    program("qemu-system-arm")


def test_every_instruction_counts_once(tmp_path):
    said = qemu.run_elf(qemu.build({"main.c": COUNTING}, tmp_path))
    one, two, thousand, many, divisions = map(int, said.split())
    assert (two - one, thousand - one, many - one) == (2, 2 * 999, 2 * 299999)
    # What is beside the loop: at most the moves of its counter.
    assert 2 <= one <= 4
    assert divisions == 3


def test_a_program_prints_and_its_floats_are_those_of_this_machine(tmp_path):
    main = r"""
#include <math.h>
#include <stdio.h>
#include "own.h"
static volatile float two = 2.0f;
int main(void) { printf("%.9g %s\n", (double)(sqrtf(two) / 3.0f), OWN); return 0; }
"""
    elf = qemu.build({"main.c": main, "own.h": '#define OWN "own"\n'}, tmp_path)
    said = qemu.run_elf(elf).split()
    assert np.float32(said[0]) == np.sqrt(np.float32(2.0)) / np.float32(3.0) and said[1] == "own"
    assert qemu.run_elf(elf).split() == said


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("return 3;", "qemu-system-arm ended with status"),
        ("return *(volatile int *)0xF0000000u;", "qemu-system-arm ended with status"),
        ("return undeclared;", "arm-none-eabi-gcc ended with status 1.*undeclared"),
    ],
)
def test_a_program_that_fails_is_told(body, message, tmp_path):
    with pytest.raises(InputError, match=f"(?s){message}"):
        qemu.run_elf(qemu.build({"main.c": f"int main(void) {{ {body} }}"}, tmp_path))


@pytest.mark.slow
def test_a_program_that_does_not_end_is_ended(monkeypatch, tmp_path):
    monkeypatch.setattr(qemu, "PATIENCE", 1.0)
    with pytest.raises(InputError, match="did not end within 1 s"):
        qemu.run_elf(qemu.build({"main.c": "int main(void) { for (;;) ; }"}, tmp_path))


def test_missing_programs_are_named_with_the_remedy(monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(InputError, match="arm-none-eabi-gcc and qemu-system-arm not installed; on Debian: apt-get"):
        qemu.require()


def test_flash_and_stack_of_a_known_unit(tmp_path):
    source = """
static const char table[1000] = {1};
__attribute__((noinline)) static int inner(volatile char *p) { volatile char room[256]; room[0] = *p; return room[0] + table[*p]; }
__attribute__((noinline)) static int other(volatile char *p) { volatile char room[64]; room[0] = *p; return room[0]; }
int outer(int n) { volatile char room[512]; room[0] = (char)n; return other(room) + inner(room); }
"""
    qemu.write({"unit.c": source}, tmp_path)
    qemu.compiled(tmp_path, "unit.c", (*qemu.FLAGS, "-fcallgraph-info=su"))
    assert 1000 + 40 < flash_bytes(tmp_path, "unit.o") < 1000 + 200
    stack = deepest_stack((tmp_path / "unit.ci").read_text(), "outer")
    assert 512 + 256 <= stack < 512 + 256 + 64
