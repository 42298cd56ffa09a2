"""The exported C under the address and undefined behaviour sanitisers, and fuzzed by libFuzzer."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from plant.law_registry import LAWS
from tests.clients import program
from tests.tuner.exchange.c99.compiled import uneven
from tests.tuner.exchange.c99.signals import step_inputs
from tuner.exchange.c99.quadrotor import c_sources

TARGET = Path(__file__).with_name("fuzz_target.c")
CHECKS = "-fsanitize=address,undefined,float-cast-overflow"
MAIN = r"""
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int main(int argc, char **argv)
{
    static uint8_t bytes[1 << 20];
    for (int i = 1; i < argc; ++i) {
        FILE *file = fopen(argv[i], "rb");
        size_t size = fread(bytes, 1, sizeof bytes, file);
        fclose(file);
        LLVMFuzzerTestOneInput(bytes, size);
    }
    printf("%d\n", argc - 1);
    return 0;
}
"""


def sources(folder, law):
    code = c_sources(uneven(law, law))
    (folder / f"{code.name}.h").write_text(code.header)
    (folder / f"{code.name}.c").write_text(code.source)
    (folder / "main.c").write_text(MAIN)
    return [f"{code.name}.c", str(TARGET)]


def corpus(folder):
    """Runs as bytes: usual ones, and ones with numbers of all sizes, NaN and infinities in them."""
    folder.mkdir()
    rng = np.random.default_rng(11)
    usual = step_inputs("sanitised", 60, 4)
    for lane in range(4):
        run = np.concatenate([usual.start[:, lane], usual.rows[:, :, lane].ravel()]).astype(np.float32)
        (folder / f"usual{lane}").write_bytes(run.tobytes())
        wild = run.view(np.uint32).copy()
        chosen = rng.random(len(wild)) < 0.02
        chosen[:18] = False
        wild[chosen] = rng.integers(0, 2**32, chosen.sum(), dtype=np.uint64).astype(np.uint32)
        (folder / f"wild{lane}").write_bytes(wild.tobytes())
    return folder


@pytest.mark.parametrize("law", ["pid", "adrc", "hybrid_gsta"])
def test_nothing_undefined_happens(law, tmp_path):
    names = sources(tmp_path, law)
    flags = ["-std=c99", "-O1", "-g", CHECKS, "-fno-sanitize-recover=all", "-I."]
    subprocess.run([program("gcc"), *flags, *names, "main.c", "-o", "run", "-lm"], cwd=tmp_path, check=True)
    files = sorted(map(str, corpus(tmp_path / "corpus").iterdir()))
    done = subprocess.run(["./run", *files], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.split() == ["8"]


def fuzzed(law, folder, seconds):
    names = sources(folder, law)
    flags = [
        "-std=c99",
        "-O1",
        "-g",
        "-fsanitize=fuzzer,address,undefined,float-cast-overflow",
        "-fno-sanitize-recover=all",
        "-I.",
    ]
    compiled = subprocess.run(
        [program("clang"), *flags, *names, "-o", "fuzz", "-lm"], cwd=folder, capture_output=True, text=True
    )
    if "clang_rt.fuzzer" in compiled.stderr:
        pytest.skip("clang is installed without libFuzzer")
    assert compiled.returncode == 0, compiled.stderr[-2000:]
    limits = [f"-max_total_time={seconds}", "-max_len=4096", "-seed=1", "-verbosity=0", "-print_final_stats=1"]
    run = subprocess.run(
        ["./fuzz", *limits, str(corpus(folder / "corpus"))], cwd=folder, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr[-2000:]
    return int(run.stderr.partition("stat::number_of_executed_units:")[2].split()[0])


@pytest.mark.slow
def test_a_fuzzer_finds_nothing_in_a_second(tmp_path):
    assert fuzzed("hybrid", tmp_path, 1) > 1000


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_a_fuzzer_finds_nothing_in_any_law(law, tmp_path):
    assert fuzzed(law, tmp_path, 20) > 10000
