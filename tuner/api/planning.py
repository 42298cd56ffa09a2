"""Before a run: its duration and the precision of its estimates."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from tuner.api.frames import Documented, frame, shown
from tuner.api.studies import AnyStudy, StudyLike, loaded
from tuner.documents.plan import PlanDocument
from tuner.experiments.planning import plan as planning
from tuner.experiments.tuning.conflicts import automatic_limit_texts
from tuner.search.watcher import Watcher

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Plan(Documented):
    """Forecast of a run.

    Attributes:
        document: A `PlanDocument`, or one that holds several as `runs` by name; as `tuner plan --json` prints it.
        study: The study that was planned.
    """

    document: Any
    study: AnyStudy

    @property
    def notes(self) -> list[str]:
        """Sentences on limits that a study does not write."""
        return automatic_limit_texts(getattr(self.study, "automatic_limits", ()))

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each objective, of a contest for each contender too: expected widths of 95 % intervals."""
        runs = {"": self.document} if isinstance(self.document, PlanDocument) else self.document.runs
        rows = [
            {
                "run": name,
                "objective": row.label,
                "unit": row.unit,
                "default": row.default,
                **{f"{stream} width": width for stream, width in row.width.content().items()},
                "scenarios_needed": row.scenarios_needed,
            }
            for name, run in runs.items()
            for row in run.objectives
        ]
        return frame(rows)

    def _repr_html_(self) -> str:
        return shown(f"Plan: {self.document.title}", getattr(self.document, "warnings", []), self.table)


def plan(
    study: StudyLike, *, difference: float = 5.0, watcher: Watcher | None = None, threads: int | None = None
) -> Plan:
    """Fly a few candidates and predict a run's effort and precision.

    Args:
        study: A tuning study or a contest, a file, or the name of a shipped study.
        difference: Difference from the default to detect [%].
        watcher: Callbacks that hear of progress.
        threads: Threads, by default one for each core.

    Returns:
        Flights, time [s], memory and disk [byte], and expected interval widths.

    Raises:
        InputError: The study is wrong, or one whose trials another program makes.

    Examples:
        >>> planned = tuner.plan(study)
        >>> planned.document.flights.search_at_most
        96

    """
    given = loaded(study)
    return Plan(planning.plan(given, 0.01 * difference, watcher, threads), given)
