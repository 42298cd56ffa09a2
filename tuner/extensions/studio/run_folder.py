"""A results folder that grows: the candidates of its generations, and its points once the run has ended."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plant.errors import StoreError
from tuner.documents.opening import kind_in
from tuner.documents.tuning import TuningFolder
from tuner.store.tables import TableFile
from tuner.study.tuning_study import TuningStudy
from tuner.text.units import in_degrees

Array = np.ndarray
MAX_CANDIDATES = 5000
"""Candidates that are shown at most, the latest first."""


@dataclass(frozen=True)
class Generation:
    """Candidates of one generation: names, gains (n, variables), objectives (n, objectives) as shown, mask of the feasible."""

    names: list[str]
    gains: Array
    values: Array
    feasible: Array


class RunFolder:
    """Folder of a run at work or ended, with its study."""

    def __init__(self, path: Path, study: TuningStudy) -> None:
        self.path, self._study = path, study
        self._read: list[Generation] = []

    @property
    def has_ended(self) -> bool:
        """Whether the run has written its results."""
        return self.path.is_dir() and kind_in(self.path) is TuningFolder

    @property
    def results(self) -> TuningFolder | None:
        """Results of the run, None before its end."""
        return TuningFolder(self.path) if self.has_ended else None

    def generations(self) -> list[Generation]:
        """Return the generations that are complete."""
        while (file := self.path / "generations" / f"{len(self._read):04d}.npz").is_file():
            try:
                self._read.append(self._generation(file))
            except StoreError:
                # A file of another version ends the picture, not the page.
                break
        return self._read

    def _generation(self, file: Path) -> Generation:
        study = self._study
        gains = [f"gain:{each.name}" for each in study.space.variables]
        objectives = [f"objective:{each.label}" for each in study.objectives]
        table = TableFile(file).block(["candidate", "feasible", *gains, *objectives])
        split = 2 + len(gains)
        factors = np.array([in_degrees(each.metric.unit).factor for each in study.objectives])
        names = [f"candidate {int(number)}" for number in table[:, 0]]
        return Generation(names, table[:, 2:split], table[:, split:] * factors, table[:, 1] > 0.5)

    def points(self, since: int = 0) -> dict[str, dict[str, float]]:
        """Return the values of the variables by point: candidates from a generation on, and the front of an ended run."""
        names = [each.name for each in self._study.space.variables]
        points = {
            name: dict(zip(names, row, strict=True))
            for generation in self.generations()[since:]
            for name, row in zip(generation.names, generation.gains.tolist(), strict=True)
        }
        results = self.results
        if results is not None:
            front = results.held_out_front
            points |= {
                p: dict(zip(names, row, strict=True)) for p, row in zip(front.points, front.gains.tolist(), strict=True)
            }
        return points
