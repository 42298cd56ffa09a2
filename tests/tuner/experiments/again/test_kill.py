"""A run that is killed at any instant and resumed ends in the bits of a run that was left alone.

The long proof, 40 instants: pytest -m slow tests/tuner/experiments/again/test_kill.py.
"""

import pytest

from plant.seeds import generator
from tests.tuner.experiments.again.killing import compare, finished_after_kill, result_of, timed
from tests.undrawn import undrawn


@pytest.fixture(scope="module", autouse=True)
def blank_figures():
    with undrawn():
        yield


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kill") / "alone"
    # The first process may have to compile the kernel; the second tells how long a run takes.
    timed(folder.with_name("warm"))
    seconds = timed(folder)
    return result_of(folder), seconds


@pytest.mark.parametrize("share", [0.45, 0.7])
def test_killed_and_resumed(alone, tmp_path, share):
    expected, seconds = alone
    finished_after_kill(tmp_path / "r", share * seconds)
    compare(result_of(tmp_path / "r"), expected)


@pytest.mark.slow
def test_killed_at_forty_instants_and_resumed(alone, tmp_path):
    expected, seconds = alone
    instants = generator(1, "test/kill", 0).uniform(0.0, seconds, 40)
    killed = 0
    for i, instant in enumerate(instants):
        killed += finished_after_kill(tmp_path / f"r{i}", float(instant))
        compare(result_of(tmp_path / f"r{i}"), expected)
    assert killed >= 30


@pytest.mark.slow
def test_killed_again_and_again(alone, tmp_path):
    """Every session is killed a little later than it began; each leaves the next one less to do."""
    from tests.tuner.experiments.again.killing import command, finish, run_arguments

    expected, seconds = alone
    import os
    import signal
    import subprocess

    folder = tmp_path / "r"
    for i in range(12):
        arguments = ["resume", folder] if (folder / "run.json").exists() else run_arguments(folder)
        process = subprocess.Popen(
            command(*arguments), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
        )
        try:
            process.wait((0.3 + 0.05 * i) * seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    finish("resume", folder)
    compare(result_of(folder), expected)
