"""The terminal side of a long run: progress while it runs, tables when it is done."""

from collections.abc import Sequence
from datetime import timedelta
from pathlib import Path
from threading import Lock
from time import perf_counter

from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, Task, TaskID, TextColumn
from rich.text import Text

from tuner.cli.printing import RunAnswer
from tuner.cli.terminal import Console
from tuner.search.loop import Generation
from tuner.search.watcher import CHECKING, COMPARING, REFINING, StartedStudy, Watcher

# Lines for the stages of a run where no live display names them.
ANNOUNCED = {
    REFINING: "Refining the best setting: up to {:,} flights",
    CHECKING: "Re-flying the finalists on held-out scenarios: {:,} flights",
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
        left = timedelta(seconds=int((task.total - task.completed) / rate))
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
        self._pace = Pace()

    def __enter__(self) -> "TerminalWatcher":
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def _begin_task(self, what: str, total: int | None) -> None:
        if self._task is not None:
            self._progress.remove_task(self._task)
        self._pace = Pace()
        self._task = self._progress.add_task(what, total=total, note="", pace=self._pace)

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

    def on_stage(self, stage: str, flights: int) -> None:
        """Start the bar of a stage."""
        if not self._live and stage in ANNOUNCED:
            self._console.print(ANNOUNCED[stage].format(flights))
        self._new = self._before = 0
        self._begin_task(stage, flights)

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
            self._progress.advance(self._task, flights)

    def on_generation(self, record: Generation, total: int) -> None:
        """Show generation, hypervolume and feasible share."""
        note = (
            f"generation {record.number + 1}/{total}  hypervolume {record.hypervolume:.4f}  "
            f"feasible {100 * record.feasible_share:.0f} %"
        )
        if self._live and self._task is not None:
            self._progress.update(self._task, note=note)
            return
        rate, flown = self._pace.rate, self._pace.flown
        if rate is None or flown == self._before:
            self._console.print(f"{note}  on record")
            return
        self._new, self._before = self._new + 1, flown
        left = self._pace.seconds / self._new * (total - record.number - 1)
        self._console.print(f"{note}  {rate:,.0f} flights/s  {left:.0f} s left")

    def on_warning(self, text: str) -> None:
        """Print it."""
        self._console.print(text, style="yellow")

    def on_answer(self, folder: Path, flights_made: int | None) -> None:
        """Print it."""
        if self._answer is not None:
            self._answer.print_folder(folder, flights_made, self._console)

    def on_writing(self, part: str) -> None:
        """Say what is being written."""
        if self._live:
            self._begin_task(f"Writing {part}", None)
