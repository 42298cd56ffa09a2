"""What every study that is searched has, whoever makes its trials, and what every study of a flown system has."""

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, NotRequired, Self, TypedDict

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.flown_system import FlownSystem
from objectives.margins.requirement import MarginRequirement
from objectives.problem import Constraint, Objective
from objectives.requirements import Requirement, Screen, requirements_of
from plant.input_files import read_input_text
from plant.quadrotor.gains import MOST_OBSERVER
from plant.texts import PlainTable
from tuner.gains.document import seed_entry
from tuner.search.convergence import StoppingRule
from tuner.search.names import CONVERGED, GENERATIONS
from tuner.study.schema import CONFIDENCE
from tuner.text.markup import element, table

if TYPE_CHECKING:
    from objectives.margins.results import Margins


class Origin(TypedDict):
    """Origin of gains, as gains.json holds it; seed: a text where a double does not hold it, feasible: only where it is False."""

    name: str
    title: str
    seed: int | str
    digest: str
    point: str
    feasible: NotRequired[bool]


@dataclass(frozen=True)
class StudyScenario:
    """A scenario and how many draws of it the search and the held-out check fly."""

    spec: Any
    search: int
    held_out: int


@dataclass(frozen=True)
class SearchSpec:
    """Settings of the search.

    first: flights of each scenario that every candidate makes, None for all; those that survive make the others. why: this search
    is asked for, in words.
    """

    algorithm: str
    population: int
    generations: int
    initial: tuple[str, ...]
    racing: bool = False
    first: int | None = None
    stop: str = GENERATIONS
    why: str = ""

    @property
    def candidates(self) -> int:
        """Candidates of all generations."""
        return self.population * self.generations

    @property
    def budget(self) -> StoppingRule:
        """Number of generations, and whether the search may end before."""
        return StoppingRule(self.generations, converges=self.stop == CONVERGED)

    def flights_first(self, flights: int) -> int:
        """Return the number of a scenario's flights that every candidate makes."""
        return flights if self.first is None else min(self.first, flights)

    @property
    def sizes(self) -> dict[str, str | int]:
        """Algorithm and sizes as a study file gives them."""
        first = {} if self.first is None else {"first": self.first}
        return {"algorithm": self.algorithm, "population": self.population, "generations": self.generations, **first}

    @property
    def values(self) -> PlainTable:
        """What decides what is searched, as JSON-able data."""
        return {**self.sizes, "initial": list(self.initial), "stop": self.stop, "racing": self.racing}

    @property
    def size(self) -> str:
        """Generations and candidates in words."""
        most = "at most " if self.stop == CONVERGED else ""
        return f"{most}{self.generations} generations of {self.population}"

    @property
    def text(self) -> str:
        """One sentence on which search it is, and why."""
        first = "" if self.first is None else f", {self.first} flights of each scenario first"
        return f"Search: {self.algorithm}, {self.size}{first}: {self.why}."


def usual_keys(confidence: float) -> tuple[str, ...]:
    """Return the keys that a digest leaves out: a study with the usual confidence keeps the digest that it had before."""
    return ("confidence",) if confidence == CONFIDENCE else ()


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
    """A study whose variables are searched, whoever makes the trials: flights of a system, or another program.

    What stands here holds where nothing is known but variables and values.

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
        """Return for each objective, by scenario, the time [s] that stands for an event that a flight did not come to."""
        return [[] for _ in self.objectives]

    @property
    def air(self) -> list[dict[str, float | str]]:
        """The air of each scenario, as summary.json holds it."""
        return []

    def drawn_numbers(self, spec: Any, stream: str, flights: int) -> np.ndarray | None:  # noqa: ARG002
        """Return deviations (flights, names) of a scenario's vehicles, None where they come from no airframe's uncertainty."""
        return None

    def flown_margins(self, gains: np.ndarray) -> "tuple[Margins, Margins] | None":  # noqa: ARG002
        """Return the margins of gains rows (n, gains), exact and of the loop in the plant steps that fly.

        None where margins are not known apart from the steps.
        """
        return None

    def loop_requirements(self) -> tuple[MarginRequirement, ...] | None:
        """Return the requirements on margins of single loops, None where loops are not looked at one by one."""
        return None

    @property
    def text(self) -> str:
        """The study as it was given."""
        return read_input_text(self.path) if self.given is None else self.given

    @property
    def content(self) -> PlainTable:
        """The content of the file, overrides and the search that was chosen included, paths relative to its folder."""
        search = self.table.search.model_copy(update=self.search.sizes)
        return self.table.model_copy(update={"search": search}).model_dump(mode="json", exclude_unset=True)

    @property
    def generations(self) -> int:
        """Generations of the search, the number that a run can be extended in."""
        return self.search.generations

    @property
    def default_row(self) -> np.ndarray:
        """Row (gains,) of the default: default and fixed values."""
        return np.array(self.space.base)

    def resolved(self) -> PlainTable:
        """Return every value of the study, defaults, airframe numbers and measured limits included, as JSON-able data."""
        search = {**self.search.values, "why": self.search.why}
        return {**self._values(), "search": search, "digest": self.digest()}

    def comparable(self, without: tuple[str, ...] = ()) -> PlainTable:
        """Return the values that decide the result, as JSON-able data by table, but for some tables; paths do not count."""
        left = ("title", "description", *usual_keys(self.table.confidence), *without)
        return {key: value for key, value in self._values().items() if key not in left}

    def _values(self) -> PlainTable:
        """Return every value of the study, as JSON-able data by table."""
        raise NotImplementedError

    def digest(self) -> str:
        """Return a hash of everything that decides the result; titles, sources and paths do not."""
        text = json.dumps(self.comparable(), sort_keys=True, allow_nan=False)
        return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()


@dataclass(frozen=True, kw_only=True)
class TuningStudy(SearchedStudy):
    """A study that searches the gains of a system.

    Args:
        system: Flies it.
        screens: Requirements that are known without flying.
        si: Whether limits known without flying stand in files in SI units, see `in_units_of_limits`.
    """

    kind: ClassVar[str] = "tuning"
    period_key: ClassVar[str] = "controller.control_period"
    """Key of gains.json that holds the control period."""
    flies: ClassVar[str] = "a quadrotor"
    """Noun of its plant, with its article."""
    limit_tables: ClassVar[str] = "a [[guarantee]] or a [[margin]]"
    """Tables of limits that are known without flying."""
    is_reread: ClassVar[bool] = True
    """Whether another process may read it again to compile its margins."""
    system: FlownSystem
    screens: tuple[Screen, ...]
    si: bool = True

    @property
    def automatic_limits(self) -> tuple[Constraint, ...]:
        """Limits that the study does not write, see `objectives.mission`."""
        return tuple(entry for entry in self.constraints if entry.floor)

    @property
    def variable_words(self) -> list[VariableWords]:
        """Symbol, meaning and unit of each searched gain; of tied ones that of the first."""
        gains = self.system.gains
        first = [gains[columns[0]] for columns in self.space.columns]
        return [VariableWords(gain.info.symbol, gain.info.meaning, gain.unit) for gain in first]

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """Requirements on the gains that are known without flying."""
        return requirements_of(self.screens)

    def resolved(self) -> PlainTable:
        """Return every value of the study, defaults, airframe numbers and measured limits included, as JSON-able data."""
        rows = [
            {
                "label": entry.label,
                "quantity": entry.quantity,
                **entry.units(),
                "limit": entry.in_file(entry.limit),
                "sense": entry.sense,
                "hard": entry.hard,
            }
            for entry in self.requirements
        ]
        values = super().resolved()
        digest = values.pop("digest")
        return {**values, "requirements": rows, "digest": digest}

    def in_units_of_limits(self) -> Self:
        """Return the study with requirements whose numbers stand in files as in the study, as folders once held them."""
        plain = tuple(
            replace(screen, requirements=tuple(replace(entry, scale=None) for entry in screen.requirements))
            for screen in self.screens
        )
        return replace(self, screens=plain, si=False)

    def origin(self, point: str) -> Origin:
        """Return the origin of a point's gains, as gains.json holds it."""
        return {
            "name": self.path.name,
            "title": self.title,
            "seed": seed_entry(self.seed),
            "digest": self.digest(),
            "point": point,
        }

    @property
    def about(self) -> tuple[tuple[str, str], ...]:
        """The plant and its laws, in a few words each."""
        raise NotImplementedError

    @property
    def followed(self) -> list[Followed]:
        """Channels that follow references, alike in all contenders of a contest; none of a quadrotor, whose axes are fixed."""
        return []

    @property
    def law_text(self) -> str:
        """The law of each loop, in words."""
        return ", ".join(f"{law.name} ({name})" for name, law in self.system.laws.items())

    @property
    def flown(self) -> str:
        """Name of the airframe or of the plant."""
        raise NotImplementedError

    @property
    def notes(self) -> list[str]:
        """Sentences on its vehicle that a person reads before a run."""
        return []

    @property
    def is_resumable(self) -> bool:
        """Whether all that flies can be read again from files, so that a run can be extended."""
        return True

    def is_natural_end(self, variable: int, bound: float) -> bool:
        """Return True if an end of a variable's range is fixed.

        The gain is meaningless beyond it, or the observer would outrun the control period.
        """
        info, period = self.system.gains[self.space.columns[variable][0]].info, self.system.timing.control_period
        return bound <= info.least or (info.observer and bound * period >= MOST_OBSERVER * (1.0 - 1e-9))

    def censored_times(self) -> list[list[float]]:
        """Return for each objective, by scenario, the time [s] that stands for an event that a flight did not come to."""
        times = []
        for objective in self.objectives:
            metric = objective.metric.metric
            seen = [entry.spec for entry in self.scenarios if objective.scenario in (None, entry.spec.name)]
            windows = [
                min(getattr(target, metric.window) if metric.window else 0.0 for target in self.system.targets(spec))
                for spec in seen
            ]
            left = [spec.duration - begin for spec, begin in zip(seen, windows, strict=True)]
            times.append(left if metric.censored is not None else [])
        return times

    def margin_model(self) -> Any:
        """Return the margins of its loop; InputError where there is no steady flight."""
        raise NotImplementedError

    def read_row(self, file: Path) -> np.ndarray:
        """Return the gains row (gains,) of a file of its controller; InputError names all that differs."""
        raise NotImplementedError

    def gains_document(self, row: np.ndarray, parts: PlainTable) -> PlainTable:
        """Return the content of gains.json for a gains row (gains,) with its parts: study, objectives, margins."""
        raise NotImplementedError

    def controller(self, gains: Iterable[float]) -> Any:
        """Return its controller with a gains row."""
        raise NotImplementedError

    def row_of(self, controller: Any, file: Path) -> np.ndarray:
        """Return the gains row (gains,) of a controller of its kind; file: gives it."""
        raise NotImplementedError

    def under(self, controller: Any, file: Path) -> Self:
        """Return the study under another controller; InputError, naming its file, where that does not fit."""
        raise NotImplementedError

    def _repr_html_(self) -> str:
        rows = (
            *self.about,
            ("searched", ", ".join(variable.name for variable in self.space.variables)),
            ("scenarios", ", ".join(entry.spec.name for entry in self.scenarios)),
            ("objectives", ", ".join(entry.label for entry in self.objectives)),
            (
                "limits",
                ", ".join([entry.objective.label for entry in self.constraints] + [e.label for e in self.requirements]),
            ),
            ("search", f"{self.search.algorithm}, {self.search.size}"),
        )
        return element("div", element("strong", self.title), table(("", f"seed {self.seed}"), rows))
