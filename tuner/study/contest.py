"""A contest, checked and ready to run: contenders that differ in controller or airframe and in nothing else."""

import hashlib
import json
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar

from objectives.metrics import MetricAddress
from objectives.problem import Objective
from objectives.risk import Risk
from plant.input_files import read_input_text
from plant.quadrotor.scenarios import CONFIRMATION
from plant.texts import PlainTable
from tuner.study.halving import HalvingSchedule
from tuner.study.study import StudyScenario, TuningStudy
from tuner.text.markup import element, table


@dataclass(frozen=True)
class Contender:
    """One entry of a contest. slug: its name in paths. raw: the content of `study` as a study file would hold it."""

    name: str
    slug: str
    study: TuningStudy
    raw: PlainTable

    @property
    def tuned(self) -> bool:
        """True where a search chooses its gains; otherwise they are flown as given."""
        return bool(self.study.space.variables)


@dataclass(frozen=True)
class Published:
    """A printed number to be judged: `value` (SI, rad) of a metric in a scenario, printed of each of `contenders`.

    fitted: the study was set to meet it, so that meeting it says nothing.
    """

    contenders: tuple[str, ...]
    metric: MetricAddress
    scenario: str
    value: float
    source: str
    fitted: bool = False

    @property
    def objective(self) -> Objective:
        """The quantity whose flights it is compared with."""
        return Objective(self.metric, Risk("mean"), self.scenario)


@dataclass(frozen=True)
class Claim:
    """A statement to be judged: `better` is lower than each of `than` in each of `objectives`."""

    better: str
    than: tuple[str, ...]
    objectives: tuple[Objective, ...]
    text: str


@dataclass(frozen=True)
class Quantity:
    """A quantity that all contenders are compared in. limit: what it must not exceed, or None. kind: "objective", "constraint",
    "published" or "claimed", the first of these that asks for it.
    """

    objective: Objective
    kind: str
    limit: float | None = None

    @property
    def label(self) -> str:
        """Unique name."""
        return self.objective.label


@dataclass(frozen=True)
class Contest:
    """Contenders with what they are judged by.

    Attributes:
        table: Merged content of the file, overrides included.
        stream: Of the scenarios on which they are compared; each contender's point is picked on held-out scenarios, which are
            others.
        halving: Of their searches, None where each is carried to its end.
    """

    kind: ClassVar[str] = "contest"
    generations: ClassVar[None] = None
    path: Path
    title: str
    description: str
    seed: int
    contenders: tuple[Contender, ...]
    published: tuple[Published, ...]
    claims: tuple[Claim, ...]
    table: PlainTable
    stream: str = CONFIRMATION
    halving: HalvingSchedule | None = None

    def _repr_html_(self) -> str:
        rows = [(c.name, c.study.flown, "tuned" if c.tuned else "as given") for c in self.contenders]
        return element("div", element("strong", self.title), table((f"seed {self.seed}", "airframe", "gains"), rows))

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
    def content(self) -> PlainTable:
        """The content of the file, see `table`."""
        return self.table

    def resolved(self) -> PlainTable:
        """Return every value of every contender's study by name, as JSON-able data."""
        return {entry.name: entry.study.resolved() for entry in self.contenders}

    def digest(self) -> str:
        """Return a hash of everything that decides the result."""
        parts = [entry.study.digest() for entry in self.contenders]
        judged = [self.table.get(key) for key in ("published", "claim")]
        halving = [asdict(self.halving)] if self.halving else []
        text = json.dumps([parts, judged, *halving], sort_keys=True, allow_nan=False)
        return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()

    @property
    def halving_texts(self) -> list[str]:
        """Sentences on the race of its searches, none without one."""
        if self.halving is None:
            return []
        rungs = self.halving.rungs(len(self.contenders))
        longest = max(contender.study.search.generations for contender in self.contenders)
        steps = [f"{rung.contenders} to {self.halving.generations(rung, longest)} generations" for rung in rungs]
        texts = [f"Successive halving: {', '.join(steps)}, {self.halving.finalists} to {longest}."]
        if not all(contender.study.search.starts for contender in self.contenders):
            texts.append(
                "Not every search has starts: after few generations fronts predict little of a search's end; name some in "
                "search.starts, or raise halving.least."
            )
        return texts

    @cached_property
    def quantities(self) -> tuple[Quantity, ...]:
        """Objectives, constraints, then what printed numbers and claims ask for; each label once."""
        labeled: dict[str, Quantity] = {}
        written = [constraint for constraint in self.base.constraints if not constraint.floor]
        limits = {constraint.objective.label: constraint.most for constraint in written}
        for kind, objectives in (
            ("objective", self.base.objectives),
            ("constraint", [constraint.objective for constraint in written]),
            ("published", [cell.objective for cell in self.published]),
            ("claimed", [objective for claim in self.claims for objective in claim.objectives]),
        ):
            for objective in objectives:
                labeled.setdefault(objective.label, Quantity(objective, kind, limits.get(objective.label)))
        return tuple(labeled.values())
