"""Progress of a call in a notebook: one output below the cell, which changes while flights are made.

A kernel of Jupyter runs IPython, whose displays have a handle that replaces their content. Worker threads report flights, up to
thousands a second, so the output changes at most four times a second.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import Any

from tuner.cli.display import Course, Pace, best_text
from tuner.search.loop import Generation
from tuner.search.watcher import BestValue, StartedStudy, Watcher
from tuner.text.markup import Markup, element, join

MIN_INTERVAL = 0.25
"""Shortest time between two changes of the output [s]."""
MAX_LINES = 12
"""Lines of messages that the output shows, the last ones."""
Show = Callable[[dict[str, str]], Callable[[dict[str, str]], None]]
"""Shows content by media type, and returns the function that replaces it."""


def notebook_watcher() -> "NotebookWatcher | None":
    """Return a watcher in a kernel of Jupyter, else None."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return NotebookWatcher(show_below) if hasattr(shell, "kernel") else None


def show_below(content: dict[str, str]) -> Callable[[dict[str, str]], None]:
    """Show content below the cell, and return the function that replaces it."""
    display: Any = sys.modules["IPython"].display
    handle = display.display(content, raw=True, display_id=True)
    return lambda other: handle.update(other, raw=True)


class NotebookWatcher(Watcher):
    """Shows messages and the progress of a call in one output.

    show: shows content below the cell; called once, with the first message or flight.
    """

    def __init__(self, show: Show) -> None:
        self._show, self._replace = show, None
        self._guard = Lock()
        self._lines: list[str] = []
        self._course, self._stage, self._best, self._note = Course({}), "", "", ""
        self._pace, self._done, self._end = Pace(), 0.0, 0.0
        self._drawn = 0.0

    def on_start(self, study: StartedStudy, folder: Path, notes: Sequence[str]) -> None:  # noqa: ARG002
        """Show the title, and notes on the study."""
        self._say(f"{study.title} (seed {study.seed})", *notes)

    def on_message(self, text: str) -> None:
        """Show it."""
        self._say(text)

    def on_warning(self, text: str) -> None:
        """Show it."""
        self._say(f"Warning: {text}")

    def on_compile_start(self) -> None:
        """Announce the compilation."""
        self._begin("Compiling the closed loop for this machine, once for these laws: 15 to 40 s", 0.0, 0.0)

    def on_compile_end(self, seconds: float) -> None:
        """Show its time."""
        self._begin("", 0.0, 0.0)
        self._say(f"Compiled in {seconds:.1f} s; the next call begins at once.")

    def on_plan(self, stages: Mapping[str, int]) -> None:
        """Keep the stages of a run."""
        self._course = Course(stages)

    def on_stage(self, stage: str, flights: int) -> None:
        """Begin a bar."""
        if stage in self._course.stages:
            begin, end = self._course.ends(stage)
            self._begin(self._course.text(stage), begin, end)
        else:
            self._begin(stage, 0.0, flights)

    def on_flights_done(self, flights: int) -> None:
        """Move the bar."""
        self._pace.add(flights)
        self._advance(flights)

    def on_flights_skipped(self, flights: int) -> None:
        """Move the bar by flights that are not made."""
        self._pace.skip()
        self._advance(flights)

    def on_best_values(self, best: Sequence[BestValue]) -> None:
        """Keep the best values for the line of the generation."""
        self._best = "; ".join(best_text(each) for each in best)

    def on_generation(self, record: Generation, total: int) -> None:
        """Show generation and best values below the bar."""
        evaluation = record.evaluation
        self._course.flown += evaluation.flights
        self._course.seconds += evaluation.flight_seconds
        with self._guard:
            self._note = f"Generation {record.number + 1} of {total}; {self._best}"
            self._draw()

    def on_answer(self, folder: Path, flights_made: int | None) -> None:
        """Show the folder of a run; its page and figures take some seconds more."""
        self._begin("", 0.0, 0.0)
        made = "" if flights_made is None else f"{flights_made:,} flights; "
        self._say(f"{made}results: {folder}")

    def _say(self, *lines: str) -> None:
        with self._guard:
            self._lines.extend(lines)
            self._draw()

    def _begin(self, stage: str, begin: float, end: float) -> None:
        with self._guard:
            self._stage, self._done, self._end, self._pace, self._note = stage, begin, end, Pace(), ""
            self._draw()

    def _advance(self, flights: int) -> None:
        with self._guard:
            self._done = min(self._done + flights, self._end)
            if self._done >= self._end or perf_counter() - self._drawn >= MIN_INTERVAL:
                self._draw()

    def _draw(self) -> None:
        self._drawn = perf_counter()
        lines = self._lines[-MAX_LINES:]
        text = self._text()
        html = join([*(element("div", line) for line in lines), self._bar(text), element("div", self._note)])
        content = {"text/html": str(element("div", html)), "text/plain": "\n".join([*lines, text, self._note]).rstrip()}
        if self._replace is None:
            self._replace = self._show(content)
        else:
            self._replace(content)

    def _bar(self, text: str) -> Markup:
        if not 0.0 < self._done < self._total:
            return element("div", text)
        bar = element("progress", value=self._done, max=self._total, aria_label=text)
        return element("div", bar, " ", text)

    @property
    def _total(self) -> float:
        return self._course.total or self._end

    def _text(self) -> str:
        """Stage, flights per second and the time that is left."""
        rate = self._pace.rate
        if rate is None or not self._stage:
            return self._stage
        time_left = self._course.time_left(self._stage, self._end - self._done, rate)
        left = f"; {time_left} left" if time_left else ""
        return f"{self._stage}: {self._pace.flown:,} flights, {rate:,.0f} flights/s{left}"
