"""What a long run tells whoever watches it; the terminal display is one watcher, silence another."""

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

from tuner.search.loop import Generation


class Watcher:
    """Hears of the progress of a run, and by default says nothing."""

    def compiling(self) -> None:
        """Hear that the closed loop is being compiled, once for this combination of laws."""

    def compiled(self, seconds: float) -> None:
        """Hear how long it took."""

    def contender(self, name: str, number: int, total: int) -> None:
        """Hear that a contender of a contest is tuned next, number 1 to total."""

    def searching(self, generations: int, flights: int) -> None:
        """Hear how many generations and flights are to come."""

    def on_flights_done(self, flights: int) -> None:
        """Called when so many more flights have ended, from worker threads."""

    def spared(self, flights: int) -> None:
        """Hear that so many more flights need not be made: they are on record, or not worth it."""
        self.on_flights_done(flights)

    def generation(self, record: Generation) -> None:
        """Hear of a finished generation."""

    def flying(self, what: str, flights: int) -> None:
        """Hear that so many flights begin; what: a participle, for instance "Sampling"."""

    def refining(self, flights: int) -> None:
        """Hear that the best of an inference is refined, with so many flights at most."""

    def verifying(self, flights: int) -> None:
        """Hear that the finalists are re-flown on held-out scenarios."""

    def comparing(self, flights: int) -> None:
        """Hear that all contenders of a contest are flown through the same scenarios of the comparison."""

    def noticed(self, text: str) -> None:
        """Hear of something that a person should know."""

    def writing(self, what: str) -> None:
        """Hear what is being written."""


@contextmanager
def told_of_compiling(watcher: Watcher) -> Iterator[None]:
    """Tell a watcher that what runs in this context compiles, and how long it took."""
    watcher.compiling()
    begin = perf_counter()
    yield
    watcher.compiled(perf_counter() - begin)
