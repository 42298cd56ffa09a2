"""inference.json: which open values would reproduce published numbers, and how well."""

from typing import Annotated, Self

from pydantic import Field

from tuner.documents.parts import Estimate, row_in_degrees, scaled
from tuner.store.document import Document, DocumentPart, OneOf, Scale
from tuner.text.units import in_degrees

SPREAD = ("mean", "median", "low68", "high68", "low95", "high95")


class InferenceSettings(DocumentPart):
    """Size of an inference: flights of a setting in the search and held out, share of the misfit that counts as near, search."""

    flights: int
    held_out: int
    near: float
    population: int
    generations: int
    tried: int


class UnknownRow(DocumentPart):
    """A value that was searched, and where it is set.

    near_low, near_high: ends of what fits about as well; low68, high68: 68 % of what other draws of the flights would give; share
    of the range that the wider of the two takes; at_end: the near range reaches an end of it; verdict: how well it is told.
    """

    name: str
    unit: str
    addresses: list[str] = Field(alias="set")
    low: float
    high: float
    scale: Scale
    default: float
    inferred: float
    near_low: float
    near_high: float
    low68: float
    high68: float
    share: float
    at_end: bool
    verdict: Annotated[str, OneOf(("told", "loosely", "not"))]

    @property
    def near(self) -> tuple[float, float]:
        """Ends of what fits about as well."""
        return self.near_low, self.near_high

    @property
    def resampled(self) -> tuple[float, float]:
        """Ends of 68 % of what other draws of the flights would give."""
        return self.low68, self.high68


class KindRow(DocumentPart):
    """A kind of metric whose misfit is told by itself."""

    metric: str
    definition: str


class SpreadPart(DocumentPart):
    """Our flights under one setting; percentile: share of them below the published value [%]; inside: between 2.5 and 97.5."""

    mean: float | None = None
    median: float
    low68: float
    high68: float
    low95: float
    high95: float
    percentile: float
    inside: bool

    @property
    def central(self) -> Estimate:
        """Median with the central 95 %."""
        return Estimate(self.median, self.low95, self.high95)


class _Reproduced(DocumentPart):
    @property
    def by(self) -> str:
        """By which setting the published value lies inside: "here" the inferred one, "near" it, "elsewhere", or "nowhere"."""
        return next((word for word, key in REPRODUCED if getattr(self, key)), "nowhere")


REPRODUCED = (("here", "inside"), ("near", "consistent"), ("elsewhere", "reproducible"))


class CellRow(_Reproduced):
    """A published number against our flights.

    ours: at the inferred setting; consistent, reproducible: inside under a setting near the least misfit, under any; ratio of our
    median to it; tolerance: how far [ln] one draw may fall from its median; best_ratio: of all settings, that nearest to 1.
    """

    contender: str
    metric: str
    kind: str
    unit: str
    scenario: str
    published: float
    ours: SpreadPart
    default: SpreadPart
    percentile: float
    inside: bool
    consistent: bool
    reproducible: bool
    ratio: float
    tolerance: float
    best_ratio: float

    def in_degrees(self) -> Self:
        """Return it with angles in degrees."""
        factor = in_degrees(self.unit).factor
        ours, default = (scaled(entry, factor, *SPREAD) for entry in (self.ours, self.default))
        return row_in_degrees(self, "published").model_copy(update={"ours": ours, "default": default})

    @property
    def nearest(self) -> float:
        """The median nearest to the published value of any setting."""
        return self.best_ratio * self.published


class RatioRow(_Reproduced):
    """A published ratio of two contenders, second to first, against that of our flights; nearest: that of any setting."""

    first: str
    second: str
    metric: str
    scenario: str
    published: float
    ours: SpreadPart
    default: SpreadPart
    percentile: float
    inside: bool
    consistent: bool
    reproducible: bool
    nearest: float


class MisfitPart(DocumentPart):
    """Misfit of a setting by kind and over all, in the search and held out, and how many published values lie inside."""

    search: dict[str, float]
    held_out: dict[str, float]
    inside: int
    ratios_inside: int


class DefaultAndInferred(DocumentPart):
    """Misfits of the default and of the inferred setting."""

    default: MisfitPart
    inferred: MisfitPart


class MissedCell(DocumentPart):
    """A published number that a setting does not reproduce."""

    contender: str
    metric: str
    scenario: str


class BestJointSetting(DocumentPart):
    """The setting under which the most cells lie inside at once in the search, and what it misses held out; of: all cells.

    most: number of cells inside, in place of search and held_out in folders of earlier versions.
    """

    most: int | None = None
    candidate: str
    search: int | None = None
    held_out: int | None = None
    of: int
    missed: list[MissedCell]


class FrontSetting(DocumentPart):
    """A non-dominated setting: its values and misfits."""

    candidate: str
    unknowns: dict[str, float]
    search: dict[str, float]
    held_out: dict[str, float]
    inside: int
    ratios_inside: int


class LostFlights(DocumentPart):
    """Share of a contender's held-out flights that failed, under the default and the inferred setting."""

    contender: str
    default: float
    inferred: float


class InferenceDocument(Document):
    """Content of inference.json. inferred: candidate; kinds: of metrics; words: all of it in sentences."""

    title: str
    description: str = ""
    study: str
    seed: int
    contenders: list[str]
    settings: InferenceSettings
    inferred: str
    unknowns: list[UnknownRow]
    kinds: list[KindRow]
    cells: list[CellRow]
    ratios: list[RatioRow]
    misfit: DefaultAndInferred
    together: BestJointSetting
    front: list[FrontSetting]
    failures: list[LostFlights]
    flights: int
    wall_seconds: float
    words: list[str]

    def in_degrees(self) -> Self:
        """Return it with published numbers and our flights in degrees, and no unit as ""."""
        return self.model_copy(update={"cells": [row.in_degrees() for row in self.cells]})

    @property
    def misfit_kinds(self) -> list[str]:
        """Names of the misfits: of each kind, and over all."""
        return [*[row.metric for row in self.kinds], "all"]

    @property
    def misfits(self) -> list[tuple[str, MisfitPart | FrontSetting]]:
        """Misfits by the name of the setting: the default, the inferred one and the front."""
        named: list[tuple[str, MisfitPart | FrontSetting]] = [
            ("default", self.misfit.default),
            (f"inferred, {self.inferred}", self.misfit.inferred),
        ]
        return named + [(row.candidate, row) for row in self.front]
