"""The process that draws, as its parent sees it.

A command that will draw starts it before anything else: what it imports, half a second, is then done on a core that has nothing
else to do yet, while the parent imports what flies.
"""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from plant.python_process import HOME, python_command

CODE = "from tuner.report.charts.printing import main; main()"
# Nothing here is worth a second thread of linear algebra, and to start them takes a tenth of the process's time.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}
Process = subprocess.Popen[bytes]
_EARLY: list[Process] = []


def started() -> Process:
    """Start a process that draws the panels on its standard input, see `printing`, and ends when its parent does."""
    # In a session of its own, Ctrl-C reaches the parent alone.
    return subprocess.Popen(
        python_command(CODE),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=HOME,
        env={**os.environ, **ONE_THREAD},
        start_new_session=True,
    )


def taken() -> Process:
    """Return the process that was started early, else a new one."""
    return _EARLY.pop() if _EARLY else started()


@contextmanager
def early() -> Iterator[None]:
    """Start the process now; at the end it is ended if it was never used."""
    _EARLY.append(started())
    try:
        yield
    finally:
        while _EARLY:
            end(_EARLY.pop())


def end(process: Process) -> None:
    """End a process, whatever it does, wait for it and close its pipes."""
    process.kill()
    with process:
        pass
