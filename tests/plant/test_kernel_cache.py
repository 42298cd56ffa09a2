"""Compiled kernels: found again by the next process, built anew when any source that went into them changes."""

import subprocess
import sys
from pathlib import Path

from plant.backends import lanes
from plant.backends.cache import cache_folder, fingerprint
from tests.plant.loops import flyer, gains, inputs, loop

ROOT = Path(__file__).parents[2]

SECOND_PROCESS = """
from tests.plant.loops import NOMINAL, flyer, gains, inputs
assert flyer().cached
flyer().fly(gains()[None], NOMINAL, inputs(range(1)))
run = flyer()._kernel
print(sum(run.stats.cache_hits.values()), sum(run.stats.cache_misses.values()))
"""

KEY = """
from plant.backends import lanes
from plant.backends.cache import fingerprint
from tests.plant.loops import loop
names, sources = lanes.kernel_names(loop())
print(fingerprint(lanes.kernel_source(loop(), names), sources))
"""


def run(code, folder):
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, '.')\n{code}"],
        cwd=folder, capture_output=True, text=True, check=True, timeout=300,
    )  # fmt: skip
    return done.stdout.split()


def test_second_process_compiles_nothing():
    from tests.plant.loops import NOMINAL

    flyer().fly(gains()[None], NOMINAL, inputs(range(1)))
    assert run(SECOND_PROCESS, ROOT) == ["1", "0"]


def test_the_key_is_the_same_in_every_process():
    names, sources = lanes.kernel_names(loop())
    assert run(KEY, ROOT) == [fingerprint(lanes.kernel_source(loop(), names), sources)]


def test_the_folder_can_be_chosen(monkeypatch, tmp_path):
    monkeypatch.setenv("TUNER_CACHE_DIR", str(tmp_path))
    assert cache_folder() == tmp_path
