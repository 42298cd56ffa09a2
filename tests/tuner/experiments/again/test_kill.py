"""A run that is killed at any instant and resumed ends in the bits of a run that was left alone.

The long proof, 40 instants: pytest -m slow tests/tuner/experiments/again/test_kill.py.
"""

import os
import signal
import subprocess

import pytest

from plant.seeds import generator
from tests.tuner.experiments.again.killing import (
    STAGES,
    command,
    compare,
    finish,
    finished_after_kill,
    result_of,
    run_arguments,
    timed,
)
from tuner.search.convergence import MIN_GENERATIONS


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kill") / "alone"
    finish(*run_arguments(folder))
    return result_of(folder)


@pytest.mark.slow
@pytest.mark.parametrize("last", ["generations/0001.npz", pytest.param("responses.npz", marks=pytest.mark.slow)])
def test_killed_and_resumed(alone, tmp_path, last):
    """Within the search, and between the documents at its end."""
    folder = tmp_path / "r"
    assert finished_after_kill(folder, lambda _: (folder / last).exists())
    compare(result_of(folder), alone)


@pytest.fixture(scope="module")
def through_all_stages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kill") / "stages"
    finish(*run_arguments(folder, STAGES))
    return result_of(folder)


@pytest.fixture(scope="module")
def seconds(through_all_stages, tmp_path_factory):
    """The time that such a run takes as a process of its own, whose kernel is compiled."""
    return timed(tmp_path_factory.mktemp("kill") / "timed", STAGES)


@pytest.mark.slow
def test_the_run_that_is_killed_goes_through_all_stages(through_all_stages):
    generations = sum(name.startswith("generations/") for name in through_all_stages)
    said = through_all_stages["summary.json"]
    assert said["search"].startswith("Search: gaussian_process") and said["settled"]["candidates"] > 0
    assert MIN_GENERATIONS <= generations < STAGES["search.generations"]
    assert any(name.startswith("flights/survivors") for name in through_all_stages)


@pytest.mark.slow
def test_killed_at_forty_instants_and_resumed(through_all_stages, seconds, tmp_path):
    """On one, two and three threads in turn."""
    instants = generator(1, "test/kill", 0).uniform(0.0, seconds, 40)
    killed = 0
    for i, instant in enumerate(instants):
        killed += finished_after_kill(tmp_path / f"r{i}", float(instant).__le__, STAGES, i % 3 + 1)
        compare(result_of(tmp_path / f"r{i}"), through_all_stages)
    # Fewer than drawn: the machine may be faster now than when the run was timed.
    assert killed >= 20


@pytest.mark.slow
def test_killed_again_and_again(through_all_stages, seconds, tmp_path):
    """Every session is killed a little later than it began; each leaves the next one less to do."""
    folder = tmp_path / "r"
    for i in range(12):
        arguments = ["resume", folder] if (folder / "run.json").exists() else run_arguments(folder, STAGES)
        process = subprocess.Popen(
            command(*arguments), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
        )
        try:
            process.wait((0.3 + 0.05 * i) * seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    finish("resume", folder)
    compare(result_of(folder), through_all_stages)
