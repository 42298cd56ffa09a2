"""Callbacks of a long run: the terminal display is one watcher, silence another."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from tuner.search.loop import Generation

SEARCHING, REFINING, CHECKING, COMPARING = "Searching", "Refining", "Held-out check", "Comparison"
"""Stages of a run, for `Watcher.on_stage`; analyses that fly once give a participle of their own, such as "Sampling"."""


class Watcher:
    """Callbacks of a run, all of which do nothing until a subclass overrides them.

    They are called from the thread that runs the experiment, but for `on_flights_done` and `on_flights_skipped`, which worker
    threads call.
    """

    def on_start(self, study: Any, folder: "Path", notes: Sequence[str]) -> None:
        """Called once, before anything else, with the study, the results folder and sentences about the study."""

    def on_message(self, text: str) -> None:
        """Called with news that needs no action, such as the size of a cluster."""

    def on_warning(self, text: str) -> None:
        """Called with something that a person should know, such as a damaged file."""

    def on_compile_start(self) -> None:
        """Called when the closed loop is about to be compiled, once for a combination of laws."""

    def on_compile_end(self, seconds: float) -> None:
        """Called when it is compiled, with the time it took [s]."""

    def on_contender(self, name: str, number: int, total: int) -> None:
        """Called when the contender of a contest with this number, of 1 to total, is about to be tuned."""

    def on_stage(self, stage: str, flights: int) -> None:
        """Called when a stage begins that takes so many flights at most."""

    def on_flights_done(self, flights: int) -> None:
        """Called when so many more flights have finished."""

    def on_flights_skipped(self, flights: int) -> None:
        """Called when so many more flights need not be made: they are on record, or not worth it."""
        self.on_flights_done(flights)

    def on_generation(self, record: "Generation", total: int) -> None:
        """Called when a generation of the search is finished, of so many in all."""

    def on_writing(self, part: str) -> None:
        """Called when a part of the results, such as "figures", is about to be written."""


@contextmanager
def compilation(watcher: Watcher) -> Iterator[None]:
    """Tell a watcher that what runs in this context compiles, and how long it took."""
    watcher.on_compile_start()
    begin = perf_counter()
    yield
    watcher.on_compile_end(perf_counter() - begin)
