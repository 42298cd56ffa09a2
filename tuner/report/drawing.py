"""Figures drawn by a process of their own while the run goes on writing: matplotlib alone takes a second to import.

That process touches no file. It hands the figures back, and the run, which holds the folder's lock, writes them. It ends
when its parent does, however that dies: its standard input is a pipe that the system then closes.
"""

import json
import os
import subprocess
import sys
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from threading import Semaphore, Thread
from typing import IO

from plant.errors import StoreError
from tuner.store.folder import put_together
from tuner.text.errors import guarded

BEGIN, STAGES = b"\n", 2
INPUT = 0
"""The file descriptor of standard input, past Python's buffer: a thread that waits in it must not hold its lock at the end."""


class Drawing:
    """Figures of a results folder, drawn by a process that imports what it needs at once and draws when told to.

    It is told twice: when the folder holds front, history and summary, and when it holds responses too.
    """

    def __init__(self, folder: Path) -> None:
        code = (
            "import sys; from tuner.report.drawing import draw; from tuner.text.errors import leave; "
            "leave(draw(sys.argv[1]))"
        )
        self._folder = folder
        # In a session of its own, Ctrl-C reaches this process alone.
        self._process = subprocess.Popen(
            [sys.executable, "-c", code, str(folder.resolve())], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, cwd=Path(__file__).parents[2], start_new_session=True,
        )  # fmt: skip
        assert self._process.stdin is not None
        # Taken away from `communicate`, which would close it before it reads.
        self._orders, self._process.stdin = self._process.stdin, None

    def begin(self) -> None:
        """Draw what the folder holds by now, see the class."""
        # Where the process has ended already, `wait` says why.
        with suppress(BrokenPipeError):
            self._orders.write(BEGIN)
            self._orders.flush()

    def stop(self) -> None:
        """Give up, whatever was begun."""
        self._process.kill()
        with suppress(BrokenPipeError):
            self._orders.close()
        # Its end closes the other pipes and waits.
        with self._process:
            pass

    def wait(self) -> None:
        """Wait for the figures and write them; StoreError says why they are not there."""
        for _ in range(STAGES):
            self.begin()
        out, errors = self._process.communicate()
        self.stop()
        files, said = received(BytesIO(out)), errors.decode(errors="replace").strip()
        if self._process.returncode or files is None:
            raise StoreError(said.splitlines()[-1].removeprefix("Error: ") if said else "no figures drawn")
        put_together(self._folder, files)


class Orders:
    """Orders of the parent on standard input, whose end is the end of the parent, and at once that of this process."""

    def __init__(self) -> None:
        self._given = Semaphore(0)
        Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        while os.read(INPUT, 1):
            self._given.release()
        os._exit(1)

    def wait(self) -> None:
        """Wait for the next order."""
        self._given.acquire()


def draw(folder: str) -> int:
    """Draw all figures of a folder when told to, and hand them over; return 0, or 2 with one line on stderr where that fails."""
    orders = Orders()

    def drawn() -> None:
        from tuner.report.figures import draw_all, make_ready

        make_ready()
        hand_over(draw_all(Path(folder), orders.wait), sys.stdout.buffer)

    return guarded(drawn)


def hand_over(files: dict[str, bytes], out: IO[bytes]) -> None:
    """Write files to a stream: a line with their names and lengths as JSON, then one after the other."""
    out.write(json.dumps({name: len(content) for name, content in files.items()}).encode() + b"\n")
    for content in files.values():
        out.write(content)
    out.flush()


def received(stream: IO[bytes]) -> dict[str, bytes] | None:
    """Return what `hand_over` wrote to a stream; None where it ended before its time."""
    try:
        lengths: dict[str, int] = json.loads(stream.readline())
    except ValueError:
        return None
    files = {name: stream.read(length) for name, length in lengths.items()}
    return files if all(len(files[name]) == length for name, length in lengths.items()) else None
