"""`tuner.sensitivity`: the gains and the turbulence that decide, by Sobol indices."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from tuner.api.frames import Documented, figures, shown
from tuner.api.studies import StudyLike, gains_study
from tuner.extensions.sensitivity.analysis import Analysis
from tuner.extensions.sensitivity.document import SensitivityDocument
from tuner.extensions.sensitivity.run import analyse_sensitivity
from tuner.extensions.sensitivity.tables import index_table, variance_table
from tuner.search.watcher import Watcher
from tuner.study.study import TuningStudy

if TYPE_CHECKING:
    import pandas as pd

    from tuner.report.charts.paper import Figure


@dataclass(frozen=True)
class Sensitivity(Documented):
    """Shares of gains and turbulence in each objective.

    Attributes:
        document: Output of `tuner sensitivity --json`.
        study: The study.
        analysis: Indices and samples behind it.
        folder: Folder of tables and chart, None if none was written.

    """

    document: SensitivityDocument
    study: TuningStudy
    analysis: Analysis
    folder: Path | None = None

    @cached_property
    def table(self) -> "pd.DataFrame":
        """Indices of each output and variable with 95 % intervals; columns as in indices.csv."""
        import pandas as pd

        return pd.DataFrame(index_table(self.study, self.analysis))

    @cached_property
    def variance(self) -> "pd.DataFrame":
        """Shares of gains and turbulence in the variance of each metric; columns as in variance.csv."""
        import pandas as pd

        return pd.DataFrame(variance_table(self.study, self.analysis))

    def figure(self) -> "Figure":
        """Draw the indices.

        Returns:
            The figure, made without pyplot.

        Examples:
            >>> tuner.sensitivity(study, samples=8).figure().savefig("sensitivity.png")

        """
        return figures("sensitivity", self.study, self.analysis).draw("sensitivity")

    def _repr_html_(self) -> str:
        return shown(f"Sensitivity: {self.study.title}", self.document.notes, self.table)


def sensitivity(
    study: StudyLike,
    *,
    samples: int = 128,
    out: str | Path | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> Sensitivity:
    """Analyze the influence of gains and turbulence on each objective.

    The influence is that of gains alone and together.

    Args:
        study: A tuning study, a file, or the name of a shipped study.
        samples: Base samples, a power of two; each takes a candidate for every variable and two more.
        out: New folder for tables and chart.
        watcher: Callbacks that hear of progress; `on_message` hears first what it will take.
        threads: Threads, by default one for each core.

    Returns:
        Sobol indices and a variance decomposition.

    Raises:
        InputError: The study is wrong or searches nothing, or samples is no power of two.
        StoreError: The folder exists already, or cannot be written.

    Examples:
        >>> found = tuner.sensitivity(study, samples=8)
        >>> found.document.flights
        288

    """
    given, folder = gains_study(study, "tuner sensitivity"), None if out is None else Path(out)
    result = analyse_sensitivity(given, samples, folder, watcher, threads)
    return Sensitivity(result.document, given, result.analysis, folder)
