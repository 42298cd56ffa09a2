"""Callbacks of a long run: the terminal display is one watcher, silence another."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple, Protocol

from tuner.extension import objects

if TYPE_CHECKING:
    from pathlib import Path

    from tuner.search.loop import Generation

SEARCHING, REFINING, CHECKING, COMPARING, JUDGING = "Searching", "Refining", "Held-out check", "Comparison", "Judging"
"""Stages of a run, for `Watcher.on_stage`; analyses that fly once give a participle of their own, such as "Sampling"."""


class BestValue(NamedTuple):
    """Smallest value of an objective so far, next to the default's.

    Attributes:
        label: Label of the objective.
        unit: Unit of the values.
        best: Smallest value of a feasible candidate, None before there is one.
        default: Value of the default.
        is_feasible: Whether the default keeps all limits.
    """

    label: str
    unit: str
    best: float | None
    default: float
    is_feasible: bool


class StartedStudy(Protocol):
    """Study of a run that begins. title: of its subject; seed: root seed."""

    @property
    def title(self) -> str:
        """Title."""
        ...

    @property
    def seed(self) -> int:
        """Root seed."""
        ...


class Watcher:
    """Callbacks of a run; each does nothing until overridden.

    They are called from the thread that runs the experiment, but for `on_flights_done` and `on_flights_skipped`, which worker
    threads call.
    """

    def on_start(self, study: StartedStudy, folder: "Path", notes: Sequence[str]) -> None:
        """Called once, first: with the study, the results folder and sentences about the study."""

    def on_message(self, text: str) -> None:
        """Called with news that need no action: such as the size of a cluster."""

    def on_warning(self, text: str) -> None:
        """Called with a warning: such as a damaged file."""

    def on_compile_start(self) -> None:
        """Called before the closed loop is compiled: once for a combination of laws."""

    def on_compile_end(self, seconds: float) -> None:
        """Called when it is compiled, with the time it took [s]."""

    def on_contender(self, name: str, number: int, total: int) -> None:
        """Called before a contender of a contest is tuned; number: from 1 to total."""

    def on_plan(self, stages: Mapping[str, int]) -> None:
        """Called before the first of several stages, with their most flights.

        The report follows the last one.
        """

    def on_stage(self, stage: str, flights: int) -> None:
        """Called when a stage begins that takes so many flights at most."""

    def on_flights_done(self, flights: int) -> None:
        """Called when so many more flights have finished."""

    def on_flights_skipped(self, flights: int) -> None:
        """Called when so many more flights need not be made: they are on record, or not worth it."""
        self.on_flights_done(flights)

    def on_best_values(self, best: Sequence[BestValue]) -> None:
        """Called before `on_generation` with the best feasible value of each objective."""

    def on_generation(self, record: "Generation", total: int) -> None:
        """Called after each generation of a search; total: of generations."""

    def on_answer(self, folder: "Path", flights_made: int | None) -> None:
        """Called when the documents of a run are in its folder.

        Report and figures follow. flights_made: None if they were not counted.
        """

    def on_writing(self, part: str) -> None:
        """Called before a part of the results is written, such as "figures"."""


def default_watcher() -> Watcher:
    """Return the watcher of a call that names none: that of an extension for this process, else silence."""
    watchers = (make() for make in objects("watchers").values())
    return next((watcher for watcher in watchers if watcher is not None), Watcher())


@contextmanager
def compilation(watcher: Watcher) -> Iterator[None]:
    """Report the compilation in this context and its time to a watcher."""
    watcher.on_compile_start()
    begin = perf_counter()
    yield
    watcher.on_compile_end(perf_counter() - begin)
