"""A small study, what flies it, and real schedulers and workers as processes of their own."""

import os
import re
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np

from objectives.problem import FlightBatch, Problem
from tests.tuner.conftest import QUICKSTART, SMALL
from tuner.study.build import load_study


def small_study(**changes):
    # Four flights of each candidate first, and what survives makes two more.
    return load_study(
        QUICKSTART,
        {**SMALL, "scenario.0.search": 6, **{key.replace("__", "."): value for key, value in changes.items()}},
    )


def problem_with(study, engine=None, memory=None):
    return Problem(study.system, study.space, study.objectives, study.constraints, study.seed, 2, (), memory, engine)


def some_gains(study, count):
    """Gains rows (count, g), all different: the default, and points of the cube."""
    points = np.random.default_rng(1).random((count - 1, len(study.space.variables)))
    return np.concatenate([study.default_row[None], study.space.gains(points)], axis=0)


def some_batch(study, flights):
    return FlightBatch(study.scenarios[0].spec, "search", flights)


@contextmanager
def process(*arguments, said, **environment):
    """Run `dask ARGUMENTS` and yield the process and what it said, once it has said something that matches `said`."""
    command = [sys.executable, "-m", "dask", *arguments]
    # A pipe that nobody reads would stop it: what it says goes to a file.
    log = environment.pop("log")
    with log.open("w") as file:
        started = subprocess.Popen(
            command, stdout=file, stderr=subprocess.STDOUT, env={**os.environ, **environment}, start_new_session=True
        )
    try:
        end = time.monotonic() + 60.0
        while not (found := re.search(said, log.read_text())):
            assert started.poll() is None and time.monotonic() < end, log.read_text()
            time.sleep(0.05)
        yield started, found.group(0)
    finally:
        started.terminate()
        started.wait(30)


def scheduler(tmp_path, *arguments):
    # Only its own: a dashboard of another run may have the usual port.
    options = arguments or ("--port", "0")
    return process(
        "scheduler",
        *options,
        "--host",
        "127.0.0.1",
        "--dashboard-address",
        ":0",
        said=r"tcp://127\.0\.0\.1:\d+",
        log=tmp_path / "scheduler.log",
    )


def worker(tmp_path, address, *arguments, name="worker", **environment):
    options = arguments or ("--nthreads", "1", "--no-nanny")
    return process(
        "worker",
        address,
        *options,
        "--local-directory",
        str(tmp_path),
        "--no-dashboard",
        said=r"Registered to",
        log=tmp_path / f"{name}.log",
        **environment,
    )


def session_of(pid):
    """Processes that are alive in the session that a process began."""
    alive = []
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                with open(f"/proc/{entry}/stat") as file:
                    fields = file.read().rsplit(")", 1)[1].split()
            except OSError:
                continue
            if int(fields[3]) == pid and fields[0] != "Z":
                alive.append(int(entry))
    return alive


def gone(pid, seconds=20.0):
    """Whether a session ends within so many seconds."""
    end = time.monotonic() + seconds
    while session_of(pid) and time.monotonic() < end:
        time.sleep(0.1)
    return not session_of(pid)
