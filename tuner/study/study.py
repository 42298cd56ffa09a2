"""A study, checked and ready to run."""

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.margins.steady_state import HOVER, SteadyState
from objectives.mission import USUAL, Mission
from objectives.problem import Constraint, Objective, System
from objectives.requirements import Requirement, Screen, requirements_of
from plant.airframes import Airframe
from plant.input_files import read_input_text
from plant.nominal import ControlOptions
from plant.origin import origins
from plant.references import ReferenceSpec
from plant.scenarios import ScenarioSpec
from tuner.gains import Controller, VehicleRecord
from tuner.gains.document import seed_entry
from tuner.search.names import CONVERGED, GENERATIONS
from tuner.search.rest import Budget
from tuner.study.schema import CONFIDENCE, StrictTable, StudyTable
from tuner.study.trim import steady_states
from tuner.text.markup import element, table


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
    def budget(self) -> Budget:
        """Number of generations, and whether the search may end before."""
        return Budget(self.generations, converges=self.stop == CONVERGED)

    def flights_first(self, flights: int) -> int:
        """Return how many of so many flights of a scenario every candidate makes."""
        return flights if self.first is None else min(self.first, flights)

    @property
    def sizes(self) -> dict[str, Any]:
        """Algorithm and sizes as a study file gives them."""
        sizes = {"algorithm": self.algorithm, "population": self.population, "generations": self.generations}
        return sizes if self.first is None else {**sizes, "first": self.first}

    @property
    def values(self) -> dict[str, Any]:
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


class VariableWords(NamedTuple):
    """Symbol, meaning and unit of a searched variable."""

    symbol: str
    meaning: str
    unit: str


class SearchedStudy(Protocol):
    """A study whose variables are searched, whoever makes the trials: flights of a plant, or another program.

    scenarios: each with `spec`, which has a name, and the numbers of its draws, `search` and `held_out`.
    """

    @property
    def path(self) -> Path:
        """The file."""
        ...

    @property
    def title(self) -> str:
        """One line that names the study."""
        ...

    @property
    def seed(self) -> int:
        """Root of every random number."""
        ...

    @property
    def space(self) -> DecisionSpace:
        """The searched variables."""
        ...

    @property
    def variable_words(self) -> list[VariableWords]:
        """Words about each variable."""
        ...

    @property
    def scenarios(self) -> tuple[Any, ...]:
        """The scenarios."""
        ...

    @property
    def objectives(self) -> tuple[Objective, ...]:
        """What is to be made small."""
        ...

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """What must not exceed a limit."""
        ...

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """Requirements that are known without a trial."""
        ...

    @property
    def search(self) -> SearchSpec:
        """The search."""
        ...

    @property
    def pick(self) -> str:
        """Rule that picks the recommended point."""
        ...

    @property
    def default_row(self) -> np.ndarray:
        """Row (gains,) of the default."""
        ...


@dataclass(frozen=True, kw_only=True)
class TuningStudy:
    """A study that searches gains: searched gains, scenarios, objectives and limits, search and pick rule, whatever flies.

    plant_step_key: where it writes the plant step. system: flies it. si: whether limits known without flying stand in files in SI
    units, see `in_units_of_limits`. given: the study as TOML, where it comes from no file. table: its content as read.
    """

    kind: ClassVar[str] = "tuning"
    plant_step_key: ClassVar[str] = "controller.plant_step"
    path: Path
    title: str
    description: str
    seed: int
    system: Any
    space: DecisionSpace
    scenarios: tuple[StudyScenario, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]
    screens: tuple[Screen, ...]
    search: SearchSpec
    pick: str
    table: Any
    si: bool = True
    given: str | None = None

    @property
    def text(self) -> str:
        """The study as it was given."""
        return read_input_text(self.path) if self.given is None else self.given

    @property
    def automatic_limits(self) -> tuple[Constraint, ...]:
        """Limits that the study does not write, see `objectives.mission`."""
        return tuple(entry for entry in self.constraints if entry.floor)

    @property
    def content(self) -> dict[str, Any]:
        """The content of the file, overrides and the search that was chosen included, paths relative to its folder."""
        search = self.table.search.model_copy(update=self.search.sizes)
        return self.table.model_copy(update={"search": search}).model_dump(mode="json", exclude_unset=True)

    @property
    def generations(self) -> int:
        """Generations of the search, the number that a run can be extended in."""
        return self.search.generations

    @property
    def default_row(self) -> np.ndarray:
        """Gains row (gains,) of the default: default and fixed gains."""
        return np.array(self.space.base)

    @property
    def variable_words(self) -> list[VariableWords]:
        """Symbol, meaning and unit of each searched gain; of tied ones that of the first."""
        known = {gain.column: gain for gain in self.system.gains}
        first = [known[columns[0]] for columns in self.space.columns]
        return [VariableWords(gain.info.symbol, gain.info.meaning, gain.unit) for gain in first]

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """Requirements on the gains that are known without flying."""
        return requirements_of(self.screens)

    def resolved(self) -> dict[str, Any]:
        """Return every value of the study, defaults, airframe numbers and measured limits included, as JSON-able data."""
        known = [
            {
                "label": entry.label, "quantity": entry.quantity, **entry.units(), "limit": entry.in_file(entry.limit),
                "sense": entry.sense, "hard": entry.hard,
            }
            for entry in self.requirements
        ]  # fmt: skip
        search = {**self.search.values, "why": self.search.why}
        return {**self._values(), "search": search, "requirements": known, "digest": self.digest()}

    def in_units_of_limits(self) -> Self:
        """Return the study with requirements whose numbers stand in files as in the study, as folders once held them."""
        plain = tuple(
            replace(screen, requirements=tuple(replace(entry, scale=None) for entry in screen.requirements))
            for screen in self.screens
        )
        return replace(self, screens=plain, si=False)

    def comparable(self, without: tuple[str, ...] = ()) -> dict[str, Any]:
        """Return what decides the result, as JSON-able data by table, but for some tables; paths do not count."""
        raise NotImplementedError

    def _values(self) -> dict[str, Any]:
        """Return every value of the study, as JSON-able data by table."""
        raise NotImplementedError

    def digest(self) -> str:
        """Return a hash of everything that decides the result; titles, sources and paths do not."""
        text = json.dumps(self.comparable(), sort_keys=True, allow_nan=False)
        return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()

    def origin(self, point: str) -> dict[str, Any]:
        """Return what gains.json says of where the gains of a point come from."""
        return {
            "name": self.path.name, "title": self.title, "seed": seed_entry(self.seed), "digest": self.digest(), "point": point,
        }  # fmt: skip

    @property
    def about(self) -> tuple[tuple[str, str], ...]:
        """The plant and its laws, in a few words each."""
        raise NotImplementedError

    @property
    def flown(self) -> str:
        """Name of the airframe or of the plant."""
        raise NotImplementedError

    @property
    def is_in_files(self) -> bool:
        """Whether all that flies can be read again from files, so that a run can be gone on with."""
        return True

    @property
    def fixes_plant_step(self) -> bool:
        """Whether the study writes the plant step."""
        raise NotImplementedError

    def _repr_html_(self) -> str:
        rows = (
            *self.about,
            ("searched", ", ".join(variable.name for variable in self.space.variables)),
            ("scenarios", ", ".join(entry.spec.name for entry in self.scenarios)),
            ("objectives", ", ".join(entry.label for entry in self.objectives)),
            ("limits", ", ".join([entry.objective.label for entry in self.constraints] + [e.label for e in self.requirements])),
            ("search", f"{self.search.algorithm}, {self.search.size}"),
        )  # fmt: skip
        return element("div", element("strong", self.title), table(("", f"seed {self.seed}"), rows))


@dataclass(frozen=True, kw_only=True)
class Study(TuningStudy):
    """A study of a quadrotor: vehicle and controller beside what every study has.

    vehicle: record of the vehicle that the default gains were imported from.
    """

    airframe: Airframe
    options: ControlOptions
    system: System
    table: StudyTable
    vehicle: VehicleRecord | None = None
    mission: Mission = USUAL

    @property
    def flown(self) -> str:
        """Name of the airframe."""
        return self.airframe.name

    def comparable(self, without: tuple[str, ...] = ()) -> dict[str, Any]:
        """Return what decides the result, as JSON-able data by table, but for some tables; paths do not count."""
        # What is usual is as it was before anything else could be asked for.
        usual = {"cost": not self.table.cost, "mission": self.mission == USUAL}
        left = {
            "title", "description", "airframe", "target", *without, *[key for key, same in usual.items() if same],
            *usual_keys(self.table.confidence),
        }  # fmt: skip
        content = {
            **self._values(),
            # The gains of its default count, under "gains".
            "controller": self._controller({"default"}),
            "scenario": self._scenarios(paths=False),
            "vehicle": self.system.vehicle,
        }
        if self.search.stop == GENERATIONS:
            content["search"] = {key: value for key, value in content["search"].items() if key != "stop"}
        return {key: value for key, value in content.items() if key not in left}

    def controller(self, gains: Iterable[float]) -> Controller:
        """Return the controller of the study with a gains row."""
        timing = self.system.timing
        return Controller(
            self.airframe, self.system.cascade, self.options, timing.control_period, timing.plant_step,
            tuple(float(gain) for gain in gains), self.vehicle, self.trims,
        )  # fmt: skip

    @cached_property
    def trims(self) -> tuple[SteadyState, ...]:
        """The steady states beside hover that its margins are judged in."""
        if all(table.at == HOVER for table in self.table.margin):
            return ()
        return steady_states([entry.spec for entry in self.scenarios], self.system)[1:]

    @property
    def fixes_plant_step(self) -> bool:
        """Whether the study writes the plant step."""
        return self.table.controller.plant_step is not None

    @property
    def about(self) -> tuple[tuple[str, str], ...]:
        """Airframe and laws."""
        cascade = self.system.cascade
        laws = f"{cascade.position.name} (position), {cascade.attitude.name} (attitude)"
        return ("airframe", self.airframe.name), ("laws", laws)

    @property
    def own_code(self) -> dict[str, dict[str, str]]:
        """Digests of the laws, metrics and references that are not bundled, by table and name."""
        cascade, judged = self.system.cascade, [*self.objectives, *[entry.objective for entry in self.constraints]]
        kinds = {type(entry.spec.reference): None for entry in self.scenarios}
        found = {
            "law": origins((cascade.position, cascade.attitude)),
            "metric": origins(entry.metric.metric for entry in judged),
            "reference": origins(kinds, "kind"),
        }
        return {table: digests for table, digests in found.items() if digests}

    def _values(self) -> dict[str, Any]:
        return {
            **_dumped(
                self.table, {"law", "metric", "reference"} | ({"target"} if self.table.target is None else set())
            ),
            # By digest: where a file lies does not count.
            **self.own_code,
            "controller": self._controller(),
            "scenario": self._scenarios(paths=True),
            "search": self.search.values,
            "airframe": {**_dumped(self.table.airframe), **_airframe_values(self.airframe)},
            "gains": {gain.address: self.space.base[gain.column] for gain in self.system.gains},
            "variables": [variable.content() for variable in self.space.variables],
        }

    def _controller(self, without: set[str] | None = None) -> dict[str, Any]:
        """Return every value of the controller, with the plant step that is flown."""
        # A study of one rate keeps the digest that it had before there were two.
        unused = {"position_every"} if self.system.cascade.position_every == 1 else set[str]()
        values = _dumped(self.table.controller, (without or set()) | unused)
        return {**values, "plant_step": self.system.timing.plant_step}

    def _scenarios(self, paths: bool) -> list[dict[str, Any]]:
        """Return every value of the scenarios; paths: with those of waypoint files, as given, so that folders can move."""
        return [
            {
                **_dumped(table),
                "spread": _spread_values(entry.spec, table.spread),
                "reference": _reference_values(entry.spec.reference, table.reference, paths),
            }  # fmt: skip
            for table, entry in zip(self.table.scenario, self.scenarios, strict=True)
        ]


def _airframe_values(airframe: Airframe) -> dict[str, Any]:
    numbers = {key: entry._asdict() for key, entry in airframe.sources.items()}
    return {"name": airframe.name, "title": airframe.title, "frame": airframe.frame, "numbers": numbers}


def _spread_values(spec: ScenarioSpec, table: Any) -> dict[str, Any]:
    """Return the spread, or where the vehicles are drawn from and the uncertainty that stands there."""
    if spec.uncertainty is None:
        return table.model_dump(mode="json", exclude={"from"})
    return {"from": getattr(table, "from"), **asdict(spec.uncertainty)}


def _reference_values(spec: ReferenceSpec, given: dict[str, Any], paths: bool) -> dict[str, Any]:
    """Return kind, every parameter and the points of a waypoint file; paths: with its path as given."""
    values = {"kind": spec.kind, **asdict(spec), **{key: value for key, value in given.items() if key == "path"}}
    return {key: value for key, value in values.items() if paths or key != "path"}


def _dumped(table: StrictTable, without: set[str] | None = None) -> dict[str, Any]:
    return table.model_dump(mode="json", by_alias=True, exclude=without)
