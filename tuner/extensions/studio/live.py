"""The page of a run at work, for `tuner run --live`: a studio in a process of its own, on the folder of the run."""

import subprocess
import sys
import webbrowser
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep

from plant.errors import InputError, ToolError
from plant.own_code import HAVE_RUN
from plant.python_process import HOME, python_command
from tuner.extensions.studio.command import require_server, serve
from tuner.extensions.studio.session import Session, open_session
from tuner.store.advice import RECORD
from tuner.study.own_code import use

PATIENCE = 60.0
"""Time [s] in which a run writes its record."""
INTERVAL = 0.1
"""Time [s] between two looks at the folder."""


@contextmanager
def live_page(folder: Path) -> Iterator[None]:
    """Show a run on a page while it works; on a terminal the page stays until Ctrl-C.

    folder: results folder that the run is to write.
    """
    require_server("tuner run --live")
    named = [str(entry.file.resolve()) for entry in HAVE_RUN.values()]
    program = "from tuner.extensions.studio.live import watch; watch(*sys.argv[1:])"
    process = subprocess.Popen(
        python_command(program, str(folder.resolve()), *named),
        cwd=HOME,
        stdin=subprocess.DEVNULL,
        stdout=sys.stderr.fileno(),
    )
    try:
        yield
        if sys.stdin.isatty() and process.poll() is None:
            print("The page stays until Ctrl-C.", file=sys.stderr, flush=True)
            process.wait()
    finally:
        process.terminate()
        process.wait()


def watch(folder: str, *code: str) -> None:
    """Serve the page of a folder until the process is ended; code: files of the user's that the run has named."""
    try:
        with suppress(KeyboardInterrupt):
            from tuner.extensions.studio.server import opened_page

            page = opened_page(opened(Path(folder), code), Path(folder).parent)
            serve(*page, webbrowser.open if sys.stderr.isatty() else None)
    except ToolError as error:
        print(f"No page: {error}", file=sys.stderr)


def opened(folder: Path, code: Sequence[str]) -> Session:
    """Return the session of a folder, once a run has begun it."""
    end = monotonic() + PATIENCE
    while not (folder / RECORD).exists():
        if monotonic() > end:
            raise InputError("no run has begun there", file=folder)
        sleep(INTERVAL)
    for file in code:
        use(file)
    return open_session(folder)
