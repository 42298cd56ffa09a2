"""A process that does nothing but draw: sheets come in on standard input, files of figures go out on standard output.

It imports neither what reads results nor what knows studies: panels are numbers and words.
"""

import gc
import json
import os
import pickle
import sys
import warnings
from queue import SimpleQueue
from threading import Thread
from typing import IO

from tuner.report.charts.sheet import FigureSpec

INPUT, HEAD = 0, 8
"""The file descriptor of standard input, past Python's buffer; bytes of the length ahead of each order."""
NEW_OBJECTS = 200_000
"""New objects after which circles of garbage are looked for; Python's own number is 700."""
Order = dict[str, FigureSpec]
"""Sheets by names of figures; an empty one is the last."""


def order(sheets: Order) -> bytes:
    """Return an order as bytes for standard input."""
    content = pickle.dumps(sheets, protocol=pickle.HIGHEST_PROTOCOL)
    return len(content).to_bytes(HEAD) + content


class ParentCommands:
    """Orders of the parent on standard input, whose end is the end of the parent, and at once that of this process."""

    def __init__(self) -> None:
        self._given: SimpleQueue[bytes] = SimpleQueue()
        Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        while True:
            self._given.put(self._bytes(int.from_bytes(self._bytes(HEAD))))

    def _bytes(self, count: int) -> bytes:
        """Return so many bytes of standard input, all that were ordered being drawn or not."""
        content = b""
        while len(content) < count:
            more = os.read(INPUT, count - len(content))
            if not more:
                os._exit(1)
            content += more
        return content

    def wait(self) -> Order:
        """Wait for the next order."""
        return pickle.loads(self._given.get())


def main() -> None:
    """Draw what is ordered until nothing is, and hand the files over all at once."""
    # A few figures make little garbage, and looking for it takes a tenth of the time.
    gc.set_threshold(NEW_OBJECTS)
    orders = ParentCommands()
    spare_imports()
    from tuner.report.charts.paper import files_of, make_ready

    make_ready()
    files: dict[str, bytes] = {}
    while sheets := orders.wait():
        files |= files_of(sheets)
    hand_over(files, sys.stdout.buffer)
    # Taking everything apart takes a tenth of a second.
    os._exit(0)


def spare_imports() -> None:
    """Leave out what matplotlib does as it is imported and is not needed here, a third of its half second."""
    # Axes in three dimensions: it goes on without, and warns.
    sys.modules["mpl_toolkits.mplot3d"] = None  # pyright: ignore[reportArgumentType]
    import matplotlib.artist

    # The lists of properties in its docstrings, and in signatures: 0.14 s.
    matplotlib.artist.kwdoc = lambda artist: ""
    matplotlib.artist.Artist._update_set_signature_and_docstring = classmethod(lambda _: None)  # pyright: ignore[reportAttributeAccessIssue]
    with warnings.catch_warnings(action="ignore", category=UserWarning):
        import matplotlib.projections  # noqa: F401


def hand_over(files: dict[str, bytes], out: IO[bytes]) -> None:
    """Write files to a stream: a line with their names and lengths as JSON, then one after the other."""
    out.write(json.dumps({name: len(content) for name, content in files.items()}).encode() + b"\n")
    for content in files.values():
        out.write(content)
    out.flush()


def received(stream: IO[bytes]) -> dict[str, bytes] | None:
    """Return the data that `hand_over` wrote to a stream; None where it ended early."""
    try:
        lengths: dict[str, int] = json.loads(stream.readline())
    except ValueError:
        return None
    files = {name: stream.read(length) for name, length in lengths.items()}
    return files if all(len(files[name]) == length for name, length in lengths.items()) else None
