"""An inference, checked and ready to run: a contest, its published cells, and what in it is not known."""

import hashlib
import json
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar, cast

import numpy as np

from objectives.decisions import DecisionSpace, Variable
from objectives.metrics import MetricAddress
from objectives.metrics.metric import Metric
from plant.texts import PlainTable
from tuner.study.contest import Contest
from tuner.study.contest_reading import contest_from_table
from tuner.study.study import SearchSpec, Study
from tuner.study.unknown_paths import Place, put_at
from tuner.text.markup import element, table

# No ratio counts for less than this: a settling time may be 0, where a band is never left, and its logarithm must stay finite.
LEAST_RATIO = 0.02


@dataclass(frozen=True)
class Unknown:
    """A value to be inferred.

    Attributes:
        variable: Name, paths and range.
        unit: Unit of the value.
        places: Places of the paths in the full file.
        flown: Places of the paths in the contest of the chosen contenders.
        default: Value as given.
    """

    variable: Variable
    unit: str
    places: tuple[Place, ...]
    flown: tuple[Place, ...]
    default: float


@dataclass(frozen=True)
class Cell:
    """One published number: a metric of a contender in a scenario; value in SI units, above 0."""

    contender: str
    metric: MetricAddress
    scenario: str
    value: float

    @property
    def label(self) -> str:
        """Short name, unique within an inference."""
        return f"{self.metric} {self.contender}@{self.scenario}"


@dataclass(frozen=True)
class Ratio:
    """Two cells of one metric and scenario; the published ratio is that of the second to the first."""

    first: int
    second: int


@dataclass(frozen=True)
class Inference:
    """Inference of unknown values from published numbers.

    Attributes:
        contest: Contest of only those contenders whose cells count.
        table: Merged content of the full file.
        flights, held_out, near: See `tuner.study.contest_schema.SettingsTable`.
    """

    kind: ClassVar[str] = "inference"
    generations: ClassVar[None] = None
    contest: Contest
    unknowns: tuple[Unknown, ...]
    cells: tuple[Cell, ...]
    search: SearchSpec
    flights: int
    held_out: int
    near: float
    table: PlainTable

    def _repr_html_(self) -> str:
        rows = [(u.variable.name, f"{u.variable.low:g} to {u.variable.high:g}") for u in self.unknowns]
        head = (f"{len(self.cells)} published numbers", "range")
        return element("div", element("strong", self.title), table(head, rows))

    def digest(self) -> str:
        """Return a hash of everything that decides the result."""
        settings = [self.table.get(key) for key in ("unknown", "inference")]
        text = json.dumps([self.contest.digest(), settings], sort_keys=True, allow_nan=False)
        return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()

    @property
    def path(self) -> Path:
        """The file it was read from."""
        return self.contest.path

    @property
    def text(self) -> str:
        """The study as it was given."""
        return self.contest.text

    @property
    def title(self) -> str:
        """Title of the contest."""
        return self.contest.title

    @property
    def seed(self) -> int:
        """Root of all draws."""
        return self.contest.seed

    @property
    def content(self) -> PlainTable:
        """The content of the file, see `table`."""
        return self.table

    @cached_property
    def space(self) -> DecisionSpace:
        """The unknowns as decision variables over a row of their values."""
        columns = tuple((i,) for i in range(len(self.unknowns)))
        variables = tuple(unknown.variable for unknown in self.unknowns)
        return DecisionSpace(variables, columns, tuple(unknown.default for unknown in self.unknowns))

    @cached_property
    def published(self) -> np.ndarray:
        """Values of the cells (cells,)."""
        return np.array([cell.value for cell in self.cells])

    @cached_property
    def kinds(self) -> tuple[Metric, ...]:
        """The metrics that the cells are of, each once; the misfit has an objective for each."""
        return tuple({cell.metric.metric.name: cell.metric.metric for cell in self.cells}.values())

    @cached_property
    def kind_of(self) -> np.ndarray:
        """Number of each cell's kind (cells,)."""
        names = [kind.name for kind in self.kinds]
        return np.array([names.index(cell.metric.metric.name) for cell in self.cells])

    @cached_property
    def ratios(self) -> tuple[Ratio, ...]:
        """Every pair of cells that differ in the contender alone."""
        keys = [(cell.metric.text, cell.scenario) for cell in self.cells]
        pairs = [(i, j) for i in range(len(keys)) for j in range(i + 1, len(keys)) if keys[i] == keys[j]]
        return tuple(Ratio(i, j) for i, j in pairs)

    def studies(self, values: np.ndarray) -> dict[str, Study]:
        """Return the contenders' studies, by name, under values of the unknowns (unknowns,)."""
        table = deepcopy(self.contest.table)
        for unknown, value in zip(self.unknowns, values, strict=True):
            for place in unknown.flown:
                put_at(table, place, float(value))
        # The reading refuses a plant.
        return {each.name: cast(Study, each.study) for each in contest_from_table(self.contest.path, table).contenders}
