"""Common parts of searched studies and of studies with flown systems."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.margins.requirement import MarginRequirement
from objectives.metrics import MetricAddress
from objectives.problem import Constraint, Objective
from objectives.requirements import Requirement
from objectives.risk import RELEVANT
from plant.errors import InputError
from plant.input_files import read_input_text
from plant.texts import PlainTable, PlainValue
from tuner.search.convergence import StoppingRule
from tuner.search.names import ALGORITHMS, CONVERGED, GENERATIONS
from tuner.study.certainty import CONFIDENCE
from tuner.study.shipped_fronts import ShippedFront
from tuner.study.starts import EarlierGains, StartSet, start_sets
from tuner.text.input_errors import located
from tuner.text.sentences import listing
from tuner.text.toml_text import SHIPPED

if TYPE_CHECKING:
    from objectives.margins.results import Margins


@dataclass(frozen=True)
class StudyScenario:
    """A scenario with its numbers of draws for search and held-out check."""

    spec: Any
    search: int
    held_out: int


@dataclass(frozen=True)
class SearchSpec:
    """Settings of the search.

    Attributes:
        first: Flights of each scenario that every candidate makes, None for all; those that survive make the others.
        reference: Labels of objectives with the values up to which the front is searched.
        flight_growth: Whether candidates make more of these where fresh ones disagree.
        why: Reason of the choice, in words.
        starts: Points of earlier runs for the first generation.
    """

    algorithm: str
    population: int
    generations: int
    initial: tuple[str, ...]
    racing: bool = False
    first: int | None = None
    flight_growth: bool = False
    reference: tuple[tuple[str, float], ...] = ()
    stop: str = GENERATIONS
    why: str = ""
    starts: tuple[StartSet, ...] = ()

    def reference_point(self, objectives: Sequence[Objective]) -> np.ndarray:
        """Return the reference point (m,) of the study; NaN where it gives none."""
        given = dict(self.reference)
        return np.array([given.get(entry.label, np.nan) for entry in objectives])

    @property
    def most_starts(self) -> int:
        """Largest number of points of earlier runs in the first generation."""
        return self.population // 2

    @property
    def most_around_starts(self) -> int:
        """Largest number of points between and around these in the first generation."""
        return self.population // 3

    @property
    def candidates(self) -> int:
        """Candidates of all generations."""
        return self.population * self.generations

    @property
    def budget(self) -> StoppingRule:
        """Number of generations, and whether the search may end before."""
        least = ALGORITHMS[self.algorithm].least_generations
        return StoppingRule(self.generations, converges=self.stop == CONVERGED, least=least)

    def flights_first(self, flights: int) -> int:
        """Return the number of a scenario's flights that every candidate makes."""
        return flights if self.first is None else min(self.first, flights)

    @property
    def sizes(self) -> dict[str, str | int | bool]:
        """Algorithm and sizes as a study file gives them."""
        first = {} if self.first is None else {"first": self.first}
        growth = {"flight_growth": True} if self.flight_growth else {}
        stop = {"stop": CONVERGED} if self.stop == CONVERGED else {}
        sizes = {"algorithm": self.algorithm, "population": self.population, "generations": self.generations}
        return {**sizes, **first, **growth, **stop}

    @property
    def values(self) -> PlainTable:
        """Data that decide the search, ready for JSON."""
        starts = {"starts": [[dict(point) for point in entry.points] for entry in self.starts]} if self.starts else {}
        reference = {"reference": dict(self.reference)} if self.reference else {}
        return {
            **self.sizes,
            "initial": list(self.initial),
            **starts,
            **reference,
            "stop": self.stop,
            "racing": self.racing,
        }

    @property
    def size(self) -> str:
        """Generations and candidates in words."""
        most = "at most " if self.stop == CONVERGED else ""
        return f"{most}{self.generations} generations of {self.population}"

    @property
    def text(self) -> str:
        """One sentence on which search it is, and why."""
        first = "" if self.first is None else f", {self.first} flights of each scenario first"
        ends = [f"{label} = {value:g}" for label, value in self.reference]
        reference = f", up to {listing(ends)}" if ends else ""
        return f"Search: {self.algorithm}, {self.size}{first}{reference}: {self.why}."


USUAL = {"confidence": CONFIDENCE, "relevant": RELEVANT}
"""Keys that a digest leaves out at these values: such a study keeps the digest that it had before there were the keys."""


def usual_keys(table: object) -> list[str]:
    """Return the keys of a study's table that its digest leaves out."""
    return [key for key, value in USUAL.items() if getattr(table, key) == value]


class Followed(NamedTuple):
    """A channel that follows a reference: its name, output, and the |error| at which a flight has failed."""

    name: str
    output: str
    limit: float

    def __str__(self) -> str:
        return f"{self.name} (output {self.output}, limit {self.limit:g})"


class VariableWords(NamedTuple):
    """Symbol, meaning and unit of a searched variable."""

    symbol: str
    meaning: str
    unit: str


@dataclass(frozen=True, kw_only=True)
class SearchedStudy:
    """A study whose variables are searched, by flights or by another program: flights of a system, or another program.

    The members here hold for any variables and values.

    Args:
        path: The file.
        title: One line that names the study.
        description: Text for the report.
        seed: Root of every random number.
        space: The searched variables.
        scenarios: Each with the numbers of its draws.
        objectives: Risks to be made small.
        constraints: Risks that must not exceed a limit.
        search: The search.
        pick: Rule that picks the recommended point.
        table: The content as read.
        given: The study as TOML, where it comes from no file.
    """

    kind: ClassVar[str]
    guards: ClassVar[frozenset[str]] = frozenset()
    """Names of the guards that look at studies of this kind alone."""
    plant_step_key: ClassVar[str] = "controller.plant_step"
    """Key of a study that sets the plant step."""
    has_designs: ClassVar[bool] = False
    """Whether its axes can be designed, see `tuner.experiments.tuning.starts`."""
    path: Path
    title: str
    description: str
    seed: int
    space: DecisionSpace
    scenarios: tuple[StudyScenario, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    search: SearchSpec
    pick: str
    table: Any
    given: str | None = None

    @property
    def variable_words(self) -> list[VariableWords]:
        """Symbol, meaning and unit of each variable."""
        raise NotImplementedError

    def _repr_html_(self) -> str:
        raise NotImplementedError

    @property
    def judged_metrics(self) -> list[MetricAddress]:
        """Metrics of its objectives and constraints."""
        return [entry.metric for entry in (*self.objectives, *(each.objective for each in self.constraints))]

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """Requirements that are known without a trial."""
        return ()

    @property
    def fixes_plant_step(self) -> bool:
        """Whether the study writes the plant step."""
        return False

    @property
    def is_resumable(self) -> bool:
        """Whether a run can be extended by `tuner resume`."""
        return False

    def is_natural_end(self, variable: int, bound: float) -> bool:  # noqa: ARG002
        """Return True if an end of a variable's range is fixed."""
        return False

    def censored_times(self) -> list[list[float]]:
        """Return by objective and scenario the time [s] of a missed event.

        The time represents an event that a flight did not come to.
        """
        return [[] for _ in self.objectives]

    @property
    def air(self) -> list[dict[str, float | str]]:
        """The air of each scenario, as summary.json holds it."""
        return []

    def drawn_numbers(self, scenario: int, stream: str, flights: int) -> np.ndarray | None:  # noqa: ARG002
        """Return deviations (flights, names) of the vehicles of a scenario.

        scenario: its number from 0. None where they come from no airframe's uncertainty.
        """
        return None

    def earlier_gains(self, file: Path) -> EarlierGains:
        """Return the gains of a file that mean the same here; InputError where none does."""
        raise NotImplementedError

    def shipped_front(self) -> ShippedFront:
        """Return the front that comes with the tool; InputError where there is none."""
        raise InputError(
            "fronts of quadrotors' laws alone come with the tool; name a results folder, or leave starts out"
        )

    @property
    def has_shipped_front(self) -> bool:
        """Whether a front of its controller comes with the tool."""
        return False

    @property
    def names_starts(self) -> bool:
        """True if the study names the start of its search."""
        return "starts" in self.table.search.model_fields_set

    def with_starts(self) -> Self:
        """Return the study with the starting points that search.starts names; InputError where one cannot be read.

        If it names none, a model begins from the front that comes with the tool.
        """
        entries = self.table.search.starts
        if not self.names_starts and self.has_shipped_front and ALGORITHMS[self.search.algorithm].screens:
            entries = [SHIPPED]
        with located(self.path, "search"):
            sets = start_sets(entries, self.path.parent, self.space, self)
        return replace(self, search=replace(self.search, starts=sets)) if sets else self

    def without_starts(self) -> Self:
        """Return the study with a search that begins from no other one."""
        return replace(self, search=replace(self.search, starts=()))

    @property
    def start_tables(self) -> list[PlainValue]:
        """Entries of search.starts that hold the points themselves."""
        return [entry.table.model_dump() for entry in self.search.starts]

    @property
    def start_texts(self) -> list[str]:
        """Sentences on the points of earlier runs that the search starts from."""
        return [text for entry in self.search.starts for text in entry.texts(self.space)]

    def flown_margins(self, gains: np.ndarray) -> "tuple[Margins, Margins] | None":  # noqa: ARG002
        """Return the margins of gains rows (n, gains), exact and as flown.

        As flown: of the loop in its plant steps. None where there are no margins apart from the steps.
        """
        return None

    def loop_requirements(self) -> tuple[MarginRequirement, ...] | None:
        """Return the requirements on margins of single loops, None if not examined."""
        return None

    @property
    def text(self) -> str:
        """The study as it was given."""
        return read_input_text(self.path) if self.given is None else self.given

    @property
    def content(self) -> PlainTable:
        """The content of the file, with overrides, search and starting points.

        Paths are relative to its folder.
        """
        starts = [entry.table for entry in self.search.starts]
        search = self.table.search.model_copy(update={**self.search.sizes, "starts": starts})
        return self.table.model_copy(update={"search": search}).model_dump(mode="json", exclude_unset=True)

    @property
    def generations(self) -> int:
        """Generations of the search, by which a run can be extended."""
        return self.search.generations

    @property
    def default_row(self) -> np.ndarray:
        """Row (gains,) of the default: default and fixed values."""
        return np.array(self.space.base)

    def resolved(self) -> PlainTable:
        """Return every value of the study as JSON-able data.

        Defaults, airframe numbers and measured limits are included.
        """
        starts = {"starts": self.start_tables} if self.search.starts else {}
        search = {**self.search.values, **starts, "why": self.search.why}
        return {**self._values(), "search": search, "digest": self.digest()}

    def comparable(self, without: tuple[str, ...] = ()) -> PlainTable:
        """Return the values that decide the result, by table, without paths.

        They are JSON-able data; without: tables to leave out.
        """
        left = ("title", "description", *usual_keys(self.table), *without)
        return {key: value for key, value in self._values().items() if key not in left}

    def _values(self) -> PlainTable:
        """Return every value of the study, as JSON-able data by table."""
        raise NotImplementedError

    def digest(self) -> str:
        """Return a hash of everything that decides the result; titles, sources and paths do not."""
        text = json.dumps(self.comparable(), sort_keys=True, allow_nan=False)
        return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()
