"""The terminal side of a long run: progress while it runs, tables when it is done."""

from collections.abc import Mapping, Sequence
from datetime import timedelta
from math import ceil
from pathlib import Path
from threading import Lock
from time import perf_counter

from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, Task, TaskID, TextColumn
from rich.text import Text

from tuner.cli.printing import RunAnswer
from tuner.cli.terminal import Console
from tuner.search.loop import Generation
from tuner.search.watcher import CHECKING, COMPARING, JUDGING, REFINING, BestValue, StartedStudy, Watcher
from tuner.text.units import after_number

REPORT_SECONDS = 5.0
"""Time [s] that documents, page and figures of a run take after its last flight."""

WRITING = "Writing"
"""Stage after the last flight."""

# Lines for the stages of a run where no live display names them.
ANNOUNCED = {
    REFINING: "Refining the best setting: up to {:,} flights",
    CHECKING: "Re-flying the finalists on held-out scenarios: {:,} flights",
    JUDGING: "Judging: {:,} flights",
    COMPARING: "Flying all contenders through the same air: {:,} flights",
}


class Pace:
    """Speed of what is flown now; what is on record, or not worth a flight, counts neither as flown nor, before it, as time."""

    def __init__(self) -> None:
        self._guard = Lock()
        self.flown, self._since = 0, perf_counter()

    def add(self, flights: int) -> None:
        """Count flights that were made."""
        with self._guard:
            self.flown += flights

    def skip(self) -> None:
        """Begin to count the time after what was on record."""
        with self._guard:
            if not self.flown:
                self._since = perf_counter()

    @property
    def seconds(self) -> float:
        """Time that was spent flying."""
        return perf_counter() - self._since if self.flown else 0.0

    @property
    def rate(self) -> float | None:
        """Flights per second, None before there are any."""
        seconds = self.seconds
        return self.flown / seconds if seconds > 0.0 else None


class Course:
    """Place of a run in its stages, counted in flights.

    stages: the most flights of each, by name; the report, which flies nothing, follows the last one. Of what flies in one stage
    alone there are none.
    """

    def __init__(self, stages: Mapping[str, int]) -> None:
        self.stages, self.count, self.total = stages, len(stages) + 1, sum(stages.values())
        # Flights of the search, and the time that they took without the choice of candidates.
        self.flown, self.seconds = 0, 0.0

    def text(self, stage: str) -> str:
        """Return the name of a stage with its number."""
        number = list(self.stages).index(stage) + 1 if stage in self.stages else self.count
        return f"Stage {number} of {self.count}: {stage}"

    def ends(self, stage: str) -> tuple[int, int]:
        """Return the flights up to a stage's begin and to its end."""
        names = list(self.stages)
        begin = sum(self.stages[name] for name in names[: names.index(stage)])
        return begin, begin + self.stages[stage]

    def later(self, stage: str, rate: float) -> float:
        """Return the time [s] of what follows a stage.

        rate: flights per second where the search has no speed of its own.
        """
        if stage not in self.stages:
            return 0.0
        speed = self.flown / self.seconds if self.seconds > 0.0 else rate
        return (self.total - self.ends(stage)[1]) / speed + REPORT_SECONDS

    def time_left(self, stage: str, flights: float, rate: float) -> timedelta:
        """Return the time to the end.

        flights: number that the stage still makes; rate: flights per second.
        """
        return timedelta(seconds=ceil(max(flights, 0.0) / rate + self.later(stage, rate)))


class PaceColumn(ProgressColumn):
    """Column of flights per second and remaining time, or of elapsed time.

    A task without flights has the elapsed time.
    """

    def render(self, task: Task) -> Text:
        """Return them, or nothing before there is a rate."""
        if task.total is None:
            return Text(f"{timedelta(seconds=int(task.elapsed or 0.0))}")
        rate = task.fields["pace"].rate
        if rate is None:
            return Text("")
        fields = task.fields
        left = fields["course"].time_left(fields["stage"], fields["end"] - task.completed, rate)
        return Text(f"{rate:,.0f} flights/s  {left} left")


class TerminalWatcher(Watcher):
    """Shows a run: a live display on a terminal, one line for each event elsewhere. Use as a context manager.

    answer: of a run, printed before its report and figures are drawn.
    """

    def __init__(self, console: Console | None = None, answer: RunAnswer | None = None) -> None:
        self._console = console = console or Console()
        self._answer = answer
        self._live = console.is_terminal
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            BarColumn(),
            PaceColumn(),
            TextColumn("{task.fields[note]}"),
            console=console,
            transient=True,
            disable=not self._live,
        )
        self._task: TaskID | None = None
        self._new = self._before = 0
        self._best: Sequence[BestValue] = ()
        self._pace = Pace()
        self._course, self._stage = Course({}), ""

    def __enter__(self) -> "TerminalWatcher":
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def _begin_task(self, what: str, total: int | None, end: float | None = None) -> None:
        """Begin a bar; end: flights up to the end of the stage, by default its total."""
        if self._task is not None:
            self._progress.remove_task(self._task)
        self._pace = Pace()
        fields = {
            "pace": self._pace,
            "course": self._course,
            "stage": self._stage,
            "end": total if end is None else end,
        }
        self._task = self._progress.add_task(what, total=total, note="", **fields)

    def on_message(self, text: str) -> None:
        """Print it."""
        self._console.print(text, soft_wrap=True)

    def on_start(self, study: StartedStudy, folder: Path, notes: Sequence[str]) -> None:
        """Print the title and what there is to say before."""
        self._console.print(f"{study.title}  (seed {study.seed})", style="bold")
        for text in notes:
            self._console.print(text)

    def on_compile_start(self) -> None:
        """Announce the one-time compilation."""
        self._console.print("Compiling the closed loop for this machine; once for these laws, 15 to 40 s.")
        self._begin_task("Compiling", None)

    def on_compile_end(self, seconds: float) -> None:
        """Say how long it took, to somebody who waited."""
        if self._live:
            self._console.print(f"Compiled in {seconds:.1f} s; the next run starts at once.")

    def on_contender(self, name: str, number: int, total: int) -> None:
        """Say whose turn it is."""
        self._console.print(f"Contender {number}/{total}: {name}")

    def on_plan(self, stages: Mapping[str, int]) -> None:
        """Begin to count the stages of a run."""
        self._course = Course(stages)

    def on_stage(self, stage: str, flights: int) -> None:
        """Start a stage: a bar of its own, or its part of the run's bar."""
        self._new = self._before = 0
        self._stage = stage
        if stage in self._course.stages:
            self._go_to(stage, flights)
            return
        if not self._live and stage in ANNOUNCED:
            self._console.print(ANNOUNCED[stage].format(flights))
        self._begin_task(stage, flights)

    def _go_to(self, stage: str, flights: int) -> None:
        begin, end = self._course.ends(stage)
        text = self._course.text(stage)
        if not self._live:
            self._console.print(f"{text}, up to {flights:,} flights")
        self._begin_task(text, self._course.total, end)
        if self._task is not None:
            self._progress.update(self._task, completed=begin)

    def on_flights_done(self, flights: int) -> None:
        """Advance the bar."""
        self._pace.add(flights)
        self._advance(flights)

    def on_flights_skipped(self, flights: int) -> None:
        """Advance the bar by flights that need not be made."""
        self._pace.skip()
        self._advance(flights)

    def _advance(self, flights: int) -> None:
        if self._live and self._task is not None:
            task = self._progress.tasks[-1]
            # A search whose candidates are given more flights makes more than were planned: its bar waits at its end.
            done = min(task.completed + flights, task.fields["end"])
            self._progress.update(self._task, completed=max(done, task.completed))

    def on_best_values(self, best: Sequence[BestValue]) -> None:
        """Keep the values for the line of the generation."""
        self._best = best

    def on_generation(self, record: Generation, total: int) -> None:
        """Show generation, hypervolume, feasible share and the best values so far."""
        note = "  ".join(
            [
                f"generation {record.number + 1}/{total}  hypervolume {record.hypervolume:.4f}",
                f"feasible {100 * record.feasible_share:.0f} %",
                *[best_text(each) for each in self._best],
            ]
        )
        evaluation = record.evaluation
        if self._pace.flown != self._before:
            self._course.flown += evaluation.flights
            self._course.seconds += evaluation.flight_seconds
        if self._live and self._task is not None:
            self._before = self._pace.flown
            self._progress.update(self._task, note=note)
            return
        rate, flown = self._pace.rate, self._pace.flown
        if rate is None or flown == self._before:
            self._console.print(f"{note}  on record")
            return
        self._new, self._before = self._new + 1, flown
        left = self._pace.seconds / self._new * (total - record.number - 1) + self._course.later(self._stage, rate)
        self._console.print(f"{note}  {rate:,.0f} flights/s  {ceil(left):,} s left")

    def on_warning(self, text: str) -> None:
        """Print it."""
        self._console.print(text, style="yellow")

    def on_answer(self, folder: Path, flights_made: int | None) -> None:
        """Print it."""
        if self._answer is not None:
            self._answer.print_folder(folder, flights_made, self._console)

    def on_writing(self, part: str) -> None:
        """Name the part that is written: each in a live display, else the stage once."""
        is_first = not self._stage.startswith(WRITING)
        self._stage = f"{WRITING} {part}"
        if self._live:
            self._begin_task(self._course.text(self._stage) if self._course.stages else self._stage, None)
        elif is_first and self._course.stages:
            self._console.print(f"{self._course.text(WRITING)} results")


def best_text(value: BestValue) -> str:
    """Return the best feasible value of an objective next to the default's."""
    unit, default = after_number(value.unit), f"{value.default:.4g}"
    best = "none feasible" if value.best is None else f"{value.best:.4g}{unit}"
    return f"{value.label} {best} (default {default}{'' if value.is_feasible else ', breaks limits'})"
