"""The answer of a command: progress while it works, then what was found, as JSON or for a person."""

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
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


class EventLines(Messages):
    """Watcher that prints progress for programs.

    Stages and finished flights go to standard error, a line of JSON each.
    """

    def __init__(self, answer: RunAnswer | None = None) -> None:
        super().__init__(answer)
        # Threads that fly report at once.
        self._guard = Lock()

    def on_stage(self, stage: str, flights: int) -> None:
        """Print it."""
        self._print({"stage": stage, "flights": flights})

    def on_flights_done(self, flights: int) -> None:
        """Print it."""
        self._print({"done": flights})

    def on_compile_start(self) -> None:
        """Print it."""
        self._print({"stage": "Compiling", "flights": 0})

    def _print(self, event: dict[str, str | int]) -> None:
        with self._guard:
            print(json.dumps({"progress": event}), file=sys.stderr, flush=True)


PROGRESS = "TUNER_PROGRESS"
"""Environment variable; "json" for events in lines of JSON."""


@contextmanager
def progress(as_json: bool, quiet: bool = False, answer: RunAnswer | None = None) -> Iterator[Watcher]:
    """Yield what shows the progress of a command: a display on the terminal, or next to JSON messages alone, none if quiet.

    answer: of a run, which is printed before report and figures are drawn.
    """
    if as_json and os.environ.get(PROGRESS) == "json":
        yield EventLines(answer)
        return
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
