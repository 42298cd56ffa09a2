"""A run keeps to the arithmetic that it began with: another machine computes with that, or refuses, or begins anew."""

import json
import os
import shutil
import subprocess
import sys

import pytest

from objectives.flown_system import FlightBatch
from objectives.memory import scenario_key
from plant.backends import processor
from plant.backends.processor import Arithmetic, Processor, arithmetic, compute_as, missing_features, this_processor
from plant.errors import StoreError
from tests.tuner.conftest import QUICKSTART, SMALL
from tests.tuner.experiments.again.killing import compare, finish, finish_elsewhere, result_of
from tuner.experiments.again.resume import recorded_study, reopen
from tuner.experiments.again.verify import verify
from tuner.experiments.registry import compute_as_reused
from tuner.search.watcher import Watcher
from tuner.store.inputs import read_record
from tuner.study.build import load_study

# Every x86 processor of the last fifteen years runs this; the compiler shapes loops for it in another way than for this one.
OTHER = {"NUMBA_CPU_NAME": "x86-64-v2"}
NO_SUCH = Processor("no-such-cpu", "+teleport,-sse2")


@pytest.fixture
def copy(small_run, tmp_path):
    shutil.copytree(small_run[1], tmp_path / "copy")
    return tmp_path / "copy"


def elsewhere(folder, **changes):
    """Have a run say that another machine computed it."""
    content = json.loads((folder / "run.json").read_text())
    content["machine"] |= changes
    (folder / "run.json").write_text(json.dumps(content))


def cut_short(folder):
    """Leave of a run what one has that was killed in its second generation."""
    for file in (
        *folder.glob("flights/search-000[12]-*"),
        *folder.glob("flights/held-out-*"),
        *folder.glob("generations/000[12]*"),
    ):
        file.unlink()
    for name in ("front.csv", "gains.json", "summary.json", "responses.npz"):
        (folder / name).unlink()


def test_a_run_says_what_it_was_computed_with(small_run):
    machine = read_record(small_run[1]).machine
    assert machine is not None and machine.arithmetic == arithmetic()
    assert json.loads((small_run[1] / "environment.json").read_text())["target"] == arithmetic().label


@pytest.mark.skipif(not this_processor().features.count("+sse2"), reason="x86-64-v2 is no processor of this kind")
@pytest.mark.slow
def test_a_resume_told_to_compile_for_another_processor_keeps_to_the_bits_of_the_run(small_run, copy):
    cut_short(copy)
    finish_elsewhere("resume", copy, env=os.environ | OTHER)
    compare(result_of(copy), result_of(small_run[1]))
    assert "\nIdentical: " in finish_elsewhere("verify", copy, "--sample", 3, env=os.environ | OTHER)


def test_what_this_processor_cannot_run_is_refused_with_reason_and_flag(copy):
    elsewhere(copy, name=NO_SUCH.name, features=NO_SUCH.features)
    for go_on in (lambda: reopen(copy, None), lambda: verify(copy, 1, 1, Watcher())):
        with pytest.raises(
            StoreError, match=r"no-such-cpu-.*lacks teleport; go on there, or .*`tuner resume .*copy --here`"
        ):
            go_on()
    with pytest.raises(StoreError, match=r"lacks teleport; .* leave --reuse out"):
        compute_as_reused((copy,))
    assert "--here" in finish("resume", copy, code=2)[1]


def test_other_loops_of_numpy_or_another_libc_are_refused(copy):
    elsewhere(copy, libraries="numpy X86_V4-00000000, glibc 2.0")
    with pytest.raises(StoreError, match=r"drawn with numpy X86_V4-00000000, glibc 2.0, here it would be numpy "):
        recorded_study(copy)


@pytest.mark.parametrize(
    "changes", [{"name": "../../elsewhere"}, {"name": 3}, {"features": "rm -rf"}, {"libraries": "\x1b[2J"}]
)
def test_a_machine_that_is_no_machine_is_a_damaged_record(copy, changes):
    elsewhere(copy, **changes)
    with pytest.raises(StoreError, match=r"run.json is damaged"):
        reopen(copy, None)


def test_here_computes_all_of_it_anew(small_run, copy):
    """What another arithmetic recorded has other keys, so none of it is taken over; in the end the folder is this machine's."""
    from tuner.experiments.tuning.run import TuningRun

    elsewhere(copy, name=NO_SUCH.name, features=NO_SUCH.features)
    start = json.loads((copy / "start.json").read_text())
    (copy / "start.json").write_text(json.dumps(start | {"machine": "no-such-cpu"}))
    for file in (copy / "flights").glob("*"):
        file.unlink()
    study, folder = reopen(copy, None, recompute=True)
    outcome = TuningRun(study, folder, Watcher(), threads=2).carry_out()
    assert outcome.problem.flights_made > 0
    compare(result_of(copy), result_of(small_run[1]))


def test_flights_of_another_arithmetic_have_another_key(monkeypatch):
    study = load_study(QUICKSTART, SMALL)
    batch = FlightBatch(study.scenarios[0].spec, "search", 4)
    known = scenario_key(study.system, study.seed, batch)
    here = arithmetic()
    for other in (here._replace(processor=NO_SUCH), here._replace(libraries="other")):
        monkeypatch.setattr(processor, "arithmetic", lambda other=other: other)
        assert scenario_key(study.system, study.seed, batch) != known


def test_a_processor_runs_what_it_has_all_features_for():
    here = this_processor()
    fewer = ",".join(entry if entry.startswith("-") else f"-{entry[1:]}" for entry in here.features.split(","))
    assert missing_features(here) == [] and missing_features(Processor("znver9", fewer)) == []
    assert missing_features(NO_SUCH) == ["teleport"]
    # Features that are not listed are those of the name.
    assert missing_features(Processor("x86-64", "")) == []
    assert ("avx512f" in missing_features(Processor("x86-64-v4", ""))) == ("+avx512f" not in here.features)
    assert missing_features(Processor("x86-64-v4", fewer)) == []
    assert missing_features(Processor("znver9", "")) == ["all of znver9"]


def test_a_process_that_has_compiled_does_not_change_over(small_run):
    here = arithmetic()
    with pytest.raises(StoreError, match="use a new process"):
        compute_as(Arithmetic(Processor("x86-64", here.processor.features), here.libraries))


CHANGED_OVER = """
import sys
from plant.backends.processor import Processor, compile_for, compiled_for, this_processor
import numba
waiting = numba.njit(lambda x: 2.0 * x)
compile_for(Processor("x86-64", ""))
assert waiting(1.5) == 3.0
assert "v" not in {line.split()[0][0] for line in waiting.inspect_asm(waiting.signatures[0]).splitlines() if "mm0" in line}
from numba.core.registry import cpu_target
numba.njit(lambda x: x + 1.0)(1.0)
print(cpu_target.target_context.codegen().magic_tuple()[1:], compiled_for().label == this_processor().label)
"""


@pytest.mark.skipif(not this_processor().features.count("+sse2"), reason="x86-64 is no processor of this kind")
def test_the_compiler_is_told():
    done = subprocess.run(
        [sys.executable, "-c", CHANGED_OVER], capture_output=True, text=True, check=True, env={**os.environ}
    )
    assert done.stdout.split("\n")[0] == "('x86-64', '') False"
