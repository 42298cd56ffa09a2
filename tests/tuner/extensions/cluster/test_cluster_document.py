"""docs/cluster.md: its commands are run as they stand there, with this machine for `head`; and what it says of bits and memory."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.tuner.experiments.again.killing import compare, finish, finish_elsewhere, result_of, run_arguments
from tests.tuner.extensions.cluster.clusters import scheduler, worker
from tuner.text.errors import NOTHING_FEASIBLE

pytest.importorskip("distributed", reason="flies on a Dask cluster: pip install distributed")

ROOT = Path(__file__).parents[4]
TEXT = (ROOT / "docs" / "cluster.md").read_text(encoding="utf-8")
COMMANDS = [line for block in re.findall(r"```console\n(.*?)```", TEXT, re.DOTALL) for line in block.splitlines()]
# pip and export change the machine; ssh needs another one.
NOT_RUN = ("pip ", "export ", "dask ssh ")


def said(beginning):
    """The arguments behind the beginning of the one command that begins so."""
    found = [line for line in COMMANDS if line.startswith(beginning)]
    assert len(found) == 1, found
    return shlex.split(found[0].removeprefix(beginning))


def small(arguments, address, folder):
    """A documented run with a smaller study, an address for tcp://head:8786 and another folder."""
    given = [address if part == "tcp://head:8786" else part for part in arguments]
    return [*given, "--out", folder, *run_arguments(folder)[4:]]


@pytest.mark.slow
def test_the_commands_of_the_document(tmp_path):
    known = ("tuner run ", "tuner resume ", "dask scheduler ", "dask worker ")
    assert all(line.startswith((*known, *NOT_RUN)) for line in COMMANDS)
    assert said("dask scheduler ") == ["--port", "8786"], "another port here: the usual one may be taken"
    assert said("dask worker ")[0] == "tcp://head:8786"
    finish(*run_arguments(tmp_path / "alone"))
    expected = result_of(tmp_path / "alone")
    with (
        scheduler(tmp_path) as (_, address),
        worker(tmp_path, address, *said("dask worker ")[1:]),
    ):
        runs = [line.split()[1:] for line in COMMANDS if line.startswith("tuner run ")]
        assert [run[-1] for run in runs] == ["local:4", "tcp://head:8786"]
        printed = finish_elsewhere(*small(runs[1], address, tmp_path / "there"), cwd=ROOT)
        assert "Cluster of 1 workers with 4 threads" in printed
        compare(result_of(tmp_path / "there"), expected)
        # With every flight there, a resumed run makes none.
        resumed = [tmp_path / "there" if part == "results/quickstart" else part for part in said("tuner resume ")]
        printed = finish_elsewhere(
            "resume", *[address if part == "tcp://head:8786" else part for part in resumed], cwd=ROOT
        )
        assert ", 0 of them now," in " ".join(printed.split())
        compare(result_of(tmp_path / "there"), expected)


@pytest.mark.slow
def test_workers_with_an_empty_cache_compile_once_and_say_so(tmp_path):
    """`local:4` as documented, into an empty cache: one process compiles, three wait for it."""
    cache = tmp_path / "cache"
    run = next(line.split()[1:] for line in COMMANDS if "local:4" in line)

    printed = finish_elsewhere(
        *small(run, "", tmp_path / "r"), cwd=ROOT, env={**os.environ, "TUNER_CACHE_DIR": str(cache)}
    )
    assert printed.count("Compiling the closed loop for this machine") == 1
    assert len(list(cache.rglob("kernel_ladrc_hybrid_*.kernel"))) == 1


# A generation of 10 000 candidates on 64 scenarios whose flights cost nothing, so that what is measured is the driver.
GENERATION = """
import sys
import numpy as np
from objectives.engine import Engine
from objectives.metrics.columns import COLUMNS
from tests.tuner.extensions.cluster.clusters import problem_with, small_study
from tuner.experiments.tuning.problem import batches

class Painted(Engine):
    arithmetic = "painted"
    def fly(self, gains, batch, first, last, on_flights_done=None):
        return np.ones((len(gains), last - first, len(COLUMNS) + 2))

study = small_study(scenario__0__search=64)
problem = problem_with(study, Painted())
result = problem.evaluate(np.random.default_rng(1).random((10_000, len(study.space.variables))), batches(study, "search"))
assert result.scores.shape[::2] == (10_000, 64)
print(next(line for line in open("/proc/self/status") if line.startswith("VmHWM")).split()[1])
"""


@pytest.mark.slow
def test_a_large_generation_is_scored_in_parts():
    """All results together would be 370 MB, and as much again to score them."""
    done = subprocess.run([sys.executable, "-c", GENERATION], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) / 1024 < 450.0


@pytest.mark.slow
def test_the_driver_of_ten_thousand_candidates_stays_under_a_gibibyte(tmp_path):
    code = (
        "import sys; from tuner.cli.main import main\n"
        "try:\n    main()\n"
        "finally:\n    print(next(x for x in open('/proc/self/status') if x.startswith('VmHWM')), file=sys.stderr)"
    )
    changes = {
        "search.population": 1000,
        "search.generations": 10,
        "scenario.0.search": 64,
        "scenario.0.held_out": 256,
        "scenario.0.duration": 1.0,
        "scenario.0.reference.time": 0.1,
        "margin": "[]",
    }
    sets = [part for key, value in changes.items() for part in ("--set", f"{key}={value}")]
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            code,
            "run",
            "studies/quickstart.toml",
            "--out",
            str(tmp_path / "r"),
            *sets,
            "--dask",
            "local:2",
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=1200,
    )
    # Whether a flight of a second keeps every limit does not matter here.
    assert done.returncode in (0, NOTHING_FEASIBLE), done.stderr
    assert int(re.findall(r"VmHWM:\s+(\d+)", done.stderr)[-1]) / 1024 < 1024.0
