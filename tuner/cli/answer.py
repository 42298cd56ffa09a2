"""The answer of a command: progress while it works, then what was found, as JSON or for a person."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tuner.cli.printing import RunAnswer, leave_with, print_result
from tuner.search.watcher import Watcher


class Messages(Watcher):
    """Watcher that prints on standard error, for commands with machine-readable output; answer: of a run."""

    def __init__(self, answer: RunAnswer | None = None) -> None:
        self._answer = answer

    def on_answer(self, folder: Path, flights_made: int | None) -> None:
        """Print it."""
        if self._answer is not None:
            self._answer.print_folder(folder, flights_made)

    def on_message(self, text: str) -> None:
        """Print it."""
        print(text, file=sys.stderr, flush=True)


@contextmanager
def progress(as_json: bool, quiet: bool = False, answer: RunAnswer | None = None) -> Iterator[Watcher]:
    """Yield what shows the progress of a command: a display on the terminal, or beside JSON messages alone, none if quiet.

    answer: of a run, which is printed before report and figures are drawn.
    """
    if as_json:
        yield Watcher() if quiet else Messages(answer)
        return
    from tuner.cli.display import TerminalWatcher

    with TerminalWatcher(answer=answer) as watcher:
        yield watcher


def answer(result: Any, as_json: bool, code: int = 0) -> None:
    """Print what was found and end; code: the exit code."""
    print_result(result, as_json)
    leave_with(code)
