"""What a report knows of a contest folder. All values stay in SI units, angles in rad: as printed numbers and sentences are."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tuner.documents.contest_document import BoundRow, ComparedOn, ComparisonDocument, ContestDocument
from tuner.documents.inference import ShownInference
from tuner.documents.parts import Estimate
from tuner.documents.results import Fan
from tuner.store.environment import Environment


class Gain(NamedTuple):
    """One gain of a contender, in the unit of the study file."""

    address: str
    value: float
    unit: str


@dataclass(frozen=True)
class ShownContender:
    """One controller as it flew. index: its place; folder: of its own results, "" for none.

    point: of its own study; searched: the variables a search chose; operations: of its laws in one control step;
    failures: share of its flights; instructions: mean of a control step on a microcontroller, None if not known.
    """

    index: int
    name: str
    slug: str
    laws: dict[str, str]
    airframe: str
    tuned: bool
    folder: str
    point: str
    gains: list[Gain]
    searched: list[str]
    operations: float
    on_bounds: list[BoundRow]
    failures: float
    instructions: float | None = None


@dataclass(frozen=True)
class ShownQuantity:
    """One number that is compared; smaller is better. unit: "" for none; limit: what it must not exceed."""

    label: str
    metric: str
    unit: str
    risk: str
    scenario: str | None
    definition: str
    limit: float | None
    kind: str


class ShownDifference(NamedTuple):
    """Second minus first contender on the same flights; lower: which of them is, None where the interval holds zero."""

    first: str
    second: str
    quantity: str
    difference: Estimate
    lower: str | None


class ShownRuling(NamedTuple):
    """A claim for one opponent in one quantity; difference: claimed better minus opponent."""

    than: str
    quantity: str
    difference: Estimate
    verdict: str


class ShownClaim(NamedTuple):
    """A sentence put to the test, its verdict, and the comparisons behind it."""

    text: str
    better: str
    verdict: str
    rows: list[ShownRuling]


@dataclass(frozen=True)
class ContenderFront:
    """The points of one contender on the flights of the comparison.

    points: names (n,); recommended: mask (n,); values, low, high (n, objectives); gains: of each point by address; lost (n,):
    flights that did not reach their end.
    """

    contender: str
    points: list[str]
    recommended: np.ndarray
    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    gains: list[dict[str, float]]
    lost: np.ndarray


class Volume(NamedTuple):
    """How much of the common box the front of a contender dominates, and of how many points it is.

    even: contenders whose front the paired difference does not tell apart from this one.
    """

    contender: str
    share: Estimate
    points: int
    even: set[str]


@dataclass(frozen=True)
class Fronts:
    """All fronts. objectives: labels; meaning, reference: of the box that the volumes are shares of."""

    objectives: list[str]
    fronts: list[ContenderFront]
    volumes: list[Volume]
    meaning: str
    reference: dict[str, float]


class ShownBest(NamedTuple):
    """The point of a front that is best in an objective while it keeps a limit in another."""

    estimate: Estimate
    point: str


@dataclass(frozen=True)
class ShownBestUnder:
    """A question of the kind "smallest A with B at most L": contender -> answer, None where no point keeps the limit."""

    objective: str
    subject_to: str
    limit: float
    rows: dict[str, ShownBest | None]


class ShownCell(NamedTuple):
    """A printed number against our flights: their mean, and their 2.5, 50 and 97.5 % points as central (value: median).

    percentile: share of our flights below the printed number [%]; inside: it lies between 2.5 and 97.5; fitted: the study
    was set to meet this number, so meeting it says nothing.
    """

    contender: str
    metric: str
    scenario: str
    unit: str
    printed: float
    source: str
    mean: float
    central: Estimate
    percentile: float
    inside: bool
    fitted: bool


class ContenderScores(NamedTuple):
    """Values of one quantity over the flights of a contender, sorted (flights,)."""

    contender: str
    quantity: str
    values: np.ndarray


class Trace(NamedTuple):
    """One signal of one flight: time [s], value and reference (instants,), NaN where there is no reference."""

    contender: str
    scenario: str
    signal: str
    unit: str
    time: np.ndarray
    value: np.ndarray
    reference: np.ndarray


class Air(NamedTuple):
    """One component of the disturbance of a flight: time [s] and value (instants,)."""

    scenario: str
    signal: str
    unit: str
    time: np.ndarray
    value: np.ndarray


@dataclass(frozen=True)
class ShownContest:
    """A contest folder. document: contest.json; environment: environment.json; study: study.toml as given.

    estimates: by contender and quantity. fronts: None where nothing was tuned; inference: None where there is none.
    """

    folder: Path
    document: ContestDocument | ComparisonDocument
    environment: Environment
    study: str
    compared_on: list[ComparedOn]
    contenders: list[ShownContender]
    quantities: list[ShownQuantity]
    estimates: dict[tuple[str, str], Estimate]
    differences: list[ShownDifference]
    fronts: Fronts | None
    best_under: list[ShownBestUnder]
    cells: list[ShownCell]
    claims: list[ShownClaim]
    scores: list[ContenderScores]
    fans: list[Fan]
    traces: list[Trace]
    air: list[Air]
    inference: ShownInference | None

    @cached_property
    def index(self) -> dict[str, int]:
        """Place of each contender by name."""
        return {entry.name: entry.index for entry in self.contenders}

    def layer(self, name: str) -> str:
        """Return what a contender's traces are called in the figures, so that they can be switched off."""
        return f"contender-{self.index[name]}"

    @cached_property
    def quantity(self) -> dict[str, ShownQuantity]:
        """Quantities by label."""
        return {entry.label: entry for entry in self.quantities}

    @cached_property
    def scenarios(self) -> list[str]:
        """Scenarios with responses, in the order of the files."""
        return list(dict.fromkeys(entry.scenario for entry in [*self.fans, *self.traces]))

    @cached_property
    def airframes(self) -> list[str]:
        """Airframes in the order of the contenders."""
        return list(dict.fromkeys(entry.airframe for entry in self.contenders))

    def best(self, label: str) -> set[str]:
        """Return the contenders with the smallest value of a quantity, none where all have the same."""
        found = [(entry.name, self.estimates.get((entry.name, label))) for entry in self.contenders]
        known = {name: entry.value for name, entry in found if entry is not None and entry.value is not None}
        least = {name for name, value in known.items() if value == min(known.values())}
        return least if len(least) < len(known) or len(known) == 1 else set()

    def close_to_best(self, label: str) -> set[str]:
        """Return the contenders that a paired difference does not tell apart from a best one."""
        best = self.best(label)
        even = [
            {entry.first, entry.second} for entry in self.differences if entry.quantity == label and entry.lower is None
        ]
        return {name for pair in even if pair & best for name in pair - best}
