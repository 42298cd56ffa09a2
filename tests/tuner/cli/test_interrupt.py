"""Ctrl-C and SIGTERM at a real process: one line that names what goes on with it, the exit code of the signal, nothing lost.

At many instants: pytest -n 0 -m slow tests/tuner/cli/test_interrupt.py.
"""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from plant.seeds import generator
from tests.tuner.experiments.again.killing import (
    assert_sealed,
    command,
    compare,
    finish,
    result_of,
    run_arguments,
    timed,
)
from tuner.text.signals import PATIENCE as PATIENCE_OF_SIGNALS

PATIENCE = 120


def started(*arguments, code=None, **named):
    """A process that listens to Ctrl-C whoever started us, and would not hear that of our terminal."""
    words = command(*arguments) if code is None else [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.Popen(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        **named,
    )


def ended(process, number=signal.SIGINT, group=False):
    """Send a signal, to the whole group as a terminal does or to the process alone, and return exit code and messages."""
    (os.killpg if group else os.kill)(process.pid, number)
    _, err = process.communicate(timeout=PATIENCE)
    return process.returncode, err


def until(there, process):
    end = time.monotonic() + PATIENCE
    while not there():
        assert process.poll() is None and time.monotonic() < end, process.communicate()
        time.sleep(0.01)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("interrupt") / "alone"
    finish(*run_arguments(folder))
    return folder


@pytest.fixture(scope="module")
def seconds(alone, tmp_path_factory):
    """The time that a run takes as a process of its own, whose kernel is compiled."""
    return timed(tmp_path_factory.mktemp("interrupt") / "timed")


@pytest.mark.parametrize(
    ("number", "code", "marker"),
    [
        (signal.SIGINT, 130, "generations/0001.npz"),
        (signal.SIGTERM, 143, "responses.npz"),
    ],
)
@pytest.mark.slow
def test_a_run_names_what_goes_on_with_it(alone, tmp_path, number, code, marker):
    folder = tmp_path / "r"
    process = started(*run_arguments(folder))
    until((folder / marker).exists, process)
    assert ended(process, number, group=True) == (code, f"Interrupted; go on with `tuner resume {folder}`.\n")
    if number == signal.SIGINT:
        finish("resume", folder)
        compare(result_of(folder), result_of(alone))
        assert_sealed(folder, alone)


@pytest.mark.slow
def test_a_command_without_a_resume_promises_none(tmp_path):
    from tests.tuner.conftest import QUICKSTART

    folder = tmp_path / "s"
    process = started("sensitivity", QUICKSTART, "--samples", 4096, "--threads", 1, "--out", folder)
    # Behind the import of scipy's Sobol sequences: a signal that lands in that C code is printed there, whoever handles it.
    until(lambda: "_sobol" in Path(f"/proc/{process.pid}/maps").read_text(), process)
    until((folder / ".lock").exists, process)
    time.sleep(0.5)
    assert process.poll() is None and (folder / ".lock").exists()
    assert ended(process) == (130, f"Interrupted; remove {folder} and give the command again.\n")


@pytest.mark.slow
def test_a_command_without_a_folder_just_ends():
    process = started("fly", "--law", "hybrid", "--seeds", 200_000, "--threads", 1)
    # Behind the import of the compiler, where the flights begin.
    until(lambda: "llvmlite" in Path(f"/proc/{process.pid}/maps").read_text(), process)
    time.sleep(1.0)
    assert process.poll() is None
    code, told = ended(process)
    # Before, it may tell that another process compiles the same kernel.
    assert (code, told.splitlines()[-1:]) == (130, ["Interrupted."])


# What raises the signal where an exception cannot be taken, or makes another one of it.
LOST = {
    "an import statement": "sys.path.insert(0, sys.argv[1])\nimport late\ntime.sleep(30)",
    "a model of pydantic": (
        "from typing import Annotated\nfrom pydantic import AfterValidator, TypeAdapter\n"
        "def check(value):\n    signal.raise_signal(signal.SIGINT)\n    return value\n"
        "TypeAdapter(Annotated[int, AfterValidator(check)] | str).validate_python(1)\ntime.sleep(30)"
    ),
    "a damaged file": (
        "class Gone:\n    def __del__(self): signal.raise_signal(signal.SIGINT)\n"
        "Gone()\nraise StoreError('run.json is damaged')"
    ),
    "threads that wait for each other": (
        "lock = threading.Lock()\nlock.acquire()\nwaiting = threading.Thread(target=lock.acquire)\nwaiting.start()\n"
        "try: signal.raise_signal(signal.SIGINT)\nfinally: waiting.join()"
    ),
    "a destructor": "class Gone:\n    def __del__(self): signal.raise_signal(signal.SIGINT)\nGone(); time.sleep(30)",
    "an import": "try: signal.raise_signal(signal.SIGINT)\nexcept BaseException: raise ImportError('numpy failed') from None",
}


@pytest.mark.parametrize("where", LOST)
def test_a_signal_is_not_lost_where_its_exception_is(where, tmp_path):
    (tmp_path / "late.py").write_text("import signal\nsignal.raise_signal(signal.SIGINT)\nwhole = True\n")
    body = "".join(f"    {line}\n" for line in LOST[where].splitlines())
    code = (
        "import signal, sys, threading, time\nfrom plant.errors import StoreError\nfrom tuner.text.errors import guarded\n"
        f"def work():\n{body}sys.exit(guarded(work))"
    )
    process, begin = started(tmp_path, code=code), time.monotonic()
    _, err = process.communicate(timeout=PATIENCE)
    assert time.monotonic() - begin < PATIENCE_OF_SIGNALS + 2.0
    assert (process.returncode, err) == (130, "Interrupted.\n")


# A signal that the main thread blocks ends no sleep there, like one that comes in the microsecond before the sleep (3 of 500 on
# a busy processor).
@pytest.mark.parametrize("blocked", [(), (signal.SIGINT,)], ids=["in the main thread", "in another thread"])
def test_the_second_signal_waits_for_nothing(blocked):
    code = (
        "import signal, sys, time\nfrom tuner.text.errors import guarded\n"
        "def work():\n"
        "    try: print('begun', flush=True); time.sleep(60)\n"
        "    finally:\n"
        f"        signal.pthread_sigmask(signal.SIG_BLOCK, {[int(number) for number in blocked]})\n"
        "        print('ending', flush=True); time.sleep(60)\n"
        "sys.exit(guarded(work))"
    )
    process = started(code=code)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    os.kill(process.pid, signal.SIGINT)
    assert process.stdout.readline() == "ending\n"
    begin = time.monotonic()
    assert ended(process) == (130, "Interrupted.\n")
    assert time.monotonic() - begin < PATIENCE_OF_SIGNALS / 2


def test_half_made_objects_are_not_destroyed():
    code = (
        "import signal\nfrom tuner.text.errors import guarded\nfrom tuner.text.signals import end_without_joining\n"
        "class Half:\n"
        "    def __init__(self): signal.raise_signal(signal.SIGINT); self.pointer = None\n"
        "    def __del__(self): self.pointer\n"
        "end_without_joining(guarded(Half))"
    )
    process = started(code=code)
    assert (process.communicate(timeout=PATIENCE)[1], process.returncode) == ("Interrupted.\n", 130)


def test_two_threads_that_end_the_process_print_one_line():
    code = (
        "import os, threading, time\nfrom tuner.text import signals\n"
        "write = os.write\n"
        "def write_slowly(*arguments):\n"
        "    time.sleep(0.1); write(*arguments); time.sleep(0.1)\n"
        "signals.os.write = write_slowly\n"
        f"threading.Thread(target=signals.end_now, args=({signal.SIGINT:d},)).start()\n"
        f"signals.end_now({signal.SIGINT:d})"
    )
    process = started(code=code)
    assert (process.communicate(timeout=PATIENCE)[1], process.returncode) == ("Interrupted.\n", 130)


def test_an_ignored_signal_stays_ignored():
    code = (
        "import signal, sys\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\nfrom tuner.text.errors import guarded\n"
        "sys.exit(guarded(lambda: signal.raise_signal(signal.SIGINT)))"
    )
    process = started(code=code)
    assert (*process.communicate(timeout=PATIENCE), process.returncode) == ("", "", 0)


def test_output_that_cannot_be_written_is_one_line():
    with open("/dev/full", "w") as full:
        done = subprocess.run(command("list", "laws"), stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == "Error: No space left on device; nothing more was written\n"


# Commands at whose beginning a signal comes: all that is imported lies there. RESULTS is a finished folder.
EARLY = {
    "show": ("show", "RESULTS"), "verify": ("verify", "RESULTS"), "resume": ("resume", "RESULTS"),
    "rejudge": ("rejudge", "RESULTS", "--out", "OUT"), "report": ("report", "RESULTS"), "check": ("check", "quickstart"),
    "margins": ("margins", "--law", "pid"), "compare": ("compare", "RESULTS", "RESULTS/gains.json", "--out", "OUT"),
}  # fmt: skip
BEGUN = "import sys; from tuner.__main__ import run; sys.stdout.write('begun\\n'); sys.stdout.flush(); run()"


def interrupt_early(command, alone, folder, instant):
    """Send Ctrl-C so many seconds after the tool's first line has run; one line, 130, at once."""
    given = {"RESULTS": alone, "OUT": folder / "out", "RESULTS/gains.json": alone / "gains.json"}
    process = started(*[given.get(word, word) for word in EARLY[command]], code=BEGUN)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    time.sleep(instant)
    if process.poll() is not None:
        process.communicate()
        return
    begin = time.monotonic()
    code, err = ended(process)
    assert time.monotonic() - begin < 5.0, (command, instant)
    if code == 0:
        return
    told = [line for line in err.splitlines() if not line.startswith("Compil")]
    # The end of the interpreter itself is not the tool's: there the signal ends it without a word.
    assert (code == -signal.SIGINT and not told) or (code, len(told)) == (130, 1), (command, instant, code, err)
    assert all(line.startswith("Interrupted") for line in told), (command, instant, err)


@pytest.mark.slow
@pytest.mark.parametrize("command", EARLY)
def test_a_signal_in_the_first_moments_is_one_line(command, alone, tmp_path):
    interrupt_early(command, alone, tmp_path, generator(2, f"test/early/{command}", 0).uniform(0.02, 1.0))


@pytest.mark.slow
def test_two_hundred_signals_in_the_first_two_seconds(alone, tmp_path):
    for i, instant in enumerate(generator(3, "test/early", 0).uniform(0.01, 2.0, 200)):
        (tmp_path / str(i)).mkdir()
        interrupt_early(list(EARLY)[i % len(EARLY)], alone, tmp_path / str(i), instant)


@pytest.mark.slow
def test_a_run_interrupted_at_forty_instants(alone, seconds, tmp_path):
    """From the first moment on: before and after the command's own work a signal ends the process without a word."""
    draw = generator(1, "test/interrupt", 0)
    for i, instant in enumerate(draw.uniform(0.0, seconds, 40)):
        folder, number = tmp_path / f"r{i}", (signal.SIGINT, signal.SIGTERM)[i % 2]
        process = started(*run_arguments(folder))
        time.sleep(instant)
        code, err = ended(process, number, group=bool(i % 3))
        if code == 0:
            continue
        assert code in (128 + number, -number) and err.count("\n") <= 1 and "Traceback" not in err, (instant, err)
        assert err.startswith("Interrupted") or not (folder / "run.json").exists(), (instant, err)
        if (folder / "run.json").exists():
            assert err == f"Interrupted; go on with `tuner resume {folder}`.\n"
            finish("resume", folder)
            compare(result_of(folder), result_of(alone))
            assert_sealed(folder, alone)
