"""A fitted plant as the Python interface has it."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from tuner.api.frames import Documented, figures, frame, shown
from tuner.extensions.plant_fit.document import PlantFitDocument
from tuner.extensions.plant_fit.intervals import FittedPlant
from tuner.extensions.plant_fit.reading import Experiment
from tuner.extensions.plant_fit.study_file import Signals, study_text

if TYPE_CHECKING:
    import pandas as pd

    from tuner.report.charts.paper import Figure


@dataclass(frozen=True)
class PlantFit(Documented):
    """A plant out of data.

    Attributes:
        document: Output of `tuner fit --json`.
        experiments: Records behind it.
        plants: Plant of each output, with its rivals and covariance.
        signals: Names and noise of its inputs and outputs.
    """

    document: PlantFitDocument
    experiments: list[Experiment]
    plants: list[FittedPlant]
    signals: Signals

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each number: value and 95 % interval."""
        rows = [{"output": row.output, **number.content()} for row in self.document.outputs for number in row.numbers]
        return frame(rows, ["output", "input", "name"])

    def study(self, law: str = "pid", title: str = "") -> str:
        """Return a study of the plant as TOML.

        Args:
            law: Law of its loops: pi, pid, adrc or ladrc.
            title: Title of the study.
        """
        named = title or f"{', '.join(self.signals.outputs)} by {', '.join(self.signals.inputs)}"
        return study_text(self.plants, self.signals, law, named)

    def figure(self, name: str = "fit") -> "Figure":
        """Draw measurement and model.

        Args:
            name: Figure: fit, residuals, step or bode.

        Returns:
            The figure, made without pyplot.
        """
        return figures("plant_fit", self).draw(name)

    def _repr_html_(self) -> str:
        chosen = [f"{row.output}: {row.structure}" for row in self.document.outputs]
        return shown(f"Fitted to {len(self.document.records)} records", chosen, self.table)
