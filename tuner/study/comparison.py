"""A comparison, checked and ready to fly: contenders that differ in controller or airframe and in nothing else."""

import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from objectives.problem import Objective
from plant.input_files import read_input_text
from plant.texts import PlainTable
from tuner.study.study import StudyScenario, TuningStudy
from tuner.text.markup import element, table


@dataclass(frozen=True)
class Contender:
    """One entry of a comparison. slug: its name in paths. raw: the content of `study` as a study file would hold it."""

    name: str
    slug: str
    study: TuningStudy
    raw: PlainTable

    @property
    def tuned(self) -> bool:
        """True where a search chooses its gains; otherwise they are flown as given."""
        return bool(self.study.space.variables)


@dataclass(frozen=True)
class Quantity:
    """A quantity that all contenders are compared in.

    Attributes:
        kind: "objective", "constraint" or another that a kind of comparison adds, the first of these that asks for it.
        limit: Largest value that is allowed, or None.
    """

    objective: Objective
    kind: str
    limit: float | None = None

    @property
    def label(self) -> str:
        """Unique name."""
        return self.objective.label


@dataclass(frozen=True)
class ComparisonStudy:
    """Contenders on the same scenarios.

    Attributes:
        stream: Name of the stream of scenarios on which they are compared.
    """

    kind: ClassVar[str] = "comparison"
    path: Path
    title: str
    description: str
    seed: int
    contenders: tuple[Contender, ...]
    stream: str

    def _repr_html_(self) -> str:
        rows = [(c.name, c.study.flown, "tuned" if c.tuned else "as given") for c in self.contenders]
        return element("div", element("strong", self.title), table((f"seed {self.seed}", "airframe", "gains"), rows))

    @property
    def content(self) -> PlainTable:
        """Content of the study file."""
        return self.base.content

    @property
    def base(self) -> TuningStudy:
        """A study that holds what all contenders share."""
        return self.contenders[0].study

    @property
    def scenarios(self) -> tuple[StudyScenario, ...]:
        """The scenarios that all contenders fly."""
        return self.base.scenarios

    @property
    def flights_each(self) -> int:
        """Number of flights of the comparison that one controller makes."""
        return sum(entry.held_out for entry in self.scenarios)

    @property
    def text(self) -> str:
        """The study as it was given."""
        return read_input_text(self.path)

    @property
    def deciding(self) -> list[Any]:
        """JSON-able data that decides the result besides the contenders' studies."""
        return []

    def resolved(self) -> PlainTable:
        """Return every value of every contender's study by name, as JSON-able data."""
        return {entry.name: entry.study.resolved() for entry in self.contenders}

    def digest(self) -> str:
        """Return a hash of everything that decides the result."""
        parts = [entry.study.digest() for entry in self.contenders]
        text = json.dumps([parts, *self.deciding], sort_keys=True, allow_nan=False)
        return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()

    @property
    def further_objectives(self) -> Sequence[tuple[str, Sequence[Objective]]]:
        """Objectives compared besides those of the base study, by kind of quantity."""
        return ()

    @cached_property
    def quantities(self) -> tuple[Quantity, ...]:
        """Objectives, constraints, then further objectives; each label once."""
        labeled: dict[str, Quantity] = {}
        written = [constraint for constraint in self.base.constraints if not constraint.floor]
        limits = {constraint.objective.label: constraint.most for constraint in written}
        for kind, objectives in (
            ("objective", self.base.objectives),
            ("constraint", [constraint.objective for constraint in written]),
            *self.further_objectives,
        ):
            for objective in objectives:
                labeled.setdefault(objective.label, Quantity(objective, kind, limits.get(objective.label)))
        return tuple(labeled.values())


def slug_of(name: str) -> str:
    """Return a name as a part of a path: lower-case letters, digits, single hyphens."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")
