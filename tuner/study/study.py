"""A study of a quadrotor, checked and ready to run."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from objectives.margins.requirement import MarginRequirement
from objectives.margins.steady_state import HOVER, SteadyState
from objectives.mission import USUAL, Mission
from objectives.system import System
from plant.air.air import summary as air_summary
from plant.errors import InputError
from plant.loop import Timing
from plant.origin import origins
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.gains import GainAddress, gain_addresses
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.scenarios import ScenarioSpec, drawn_numbers
from plant.references import ReferenceSpec
from plant.texts import PlainTable
from tuner.gains import Controller, VehicleRecord, read_gains, to_document
from tuner.search.names import GENERATIONS
from tuner.study.fitted import fitted_texts
from tuner.study.margins import margin_requirement, nominal_margins
from tuner.study.schema import StudyTable
from tuner.study.searched import SearchedStudy, SearchSpec, StudyScenario, VariableWords, usual_keys
from tuner.study.shipped_fronts import ShippedFront, shipped_front, shipped_fronts
from tuner.study.starts import EarlierGains
from tuner.study.step_costs import cost_rows
from tuner.study.trim import hover_of, steady_states, trim_entry, trim_texts
from tuner.study.tuning_study import TuningStudy
from tuner.text.sentences import differing, listing
from tuner.text.strict_table import StrictTable

__all__ = ["SearchSpec", "SearchedStudy", "Study", "StudyScenario", "TuningStudy", "VariableWords", "usual_keys"]

if TYPE_CHECKING:
    from objectives.margins.margins import MarginModel

LOOPS = ("attitude", "position")


@dataclass(frozen=True, kw_only=True)
class Study(TuningStudy):
    """A study of a quadrotor: vehicle and controller next to what every study has.

    vehicle: record of the vehicle that the default gains were imported from.
    """

    guards: ClassVar[frozenset[str]] = frozenset(
        ("default_elsewhere", "rates_without_damping", "leading_yaw", "unlimited_margins")
    )
    has_designs: ClassVar[bool] = True
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

    def comparable(self, without: tuple[str, ...] = ()) -> PlainTable:
        """Return all that decides the result, as JSON-able data by table; some tables and all paths are left out."""
        # What is usual is as it was before anything else could be asked for.
        usual = {"cost": not self.table.cost, "mission": self.mission == USUAL}
        left = {
            "title",
            "description",
            "airframe",
            "target",
            *without,
            *[key for key, same in usual.items() if same],
            *usual_keys(self.table),
        }
        content = {
            **self._values(),
            # The gains of its default count, under "gains".
            "controller": self._controller({"default"}),
            "scenario": self._scenarios(paths=False),
            "vehicle": self.system.vehicle,
        }
        if self.search.stop == GENERATIONS:
            content["search"] = {key: value for key, value in self.search.values.items() if key != "stop"}
        return {key: value for key, value in content.items() if key not in left}

    @property
    def present_gains(self) -> Path | None:
        """The file of the gains that a vehicle flies; None of a study for no firmware."""
        file = self.table.controller.default
        return None if self.table.target is None or file is None else self.path.parent / file

    def controller(self, gains: Iterable[float]) -> Controller:
        """Return the controller of the study with a gains row."""
        timing = self.system.timing
        return Controller(
            self.airframe,
            self.system.cascade,
            self.options,
            timing.control_period,
            timing.plant_step,
            tuple(float(gain) for gain in gains),
            self.vehicle,
            self.trims,
        )

    @cached_property
    def trims(self) -> tuple[SteadyState, ...]:
        """The steady states besides hover that its margins are judged in."""
        if all(table.at == HOVER for table in self.table.margin):
            return ()
        return steady_states([entry.spec for entry in self.scenarios], self.system)[1:]

    @property
    def fixes_plant_step(self) -> bool:
        """Whether the study writes the plant step."""
        return self.table.controller.plant_step is not None

    @property
    def about(self) -> tuple[tuple[str, str], ...]:
        """Its airframe."""
        return ("airframe", self.airframe.name), ("laws", self.law_text)

    @property
    def notes(self) -> list[str]:
        """Sentences on the vehicle's fitted numbers and on trims in wind."""
        return [*fitted_texts(self.system), *trim_texts([entry.spec for entry in self.scenarios], self.system)]

    @property
    def air(self) -> list[dict[str, float | str]]:
        """The air of each scenario, with the trim of its flights' start."""
        return [
            {"scenario": entry.spec.name, **air_summary(entry.spec.air), **trim_entry(entry.spec, self.system)}
            for entry in self.scenarios
        ]

    def drawn_numbers(self, scenario: int, stream: str, flights: int) -> np.ndarray | None:
        """Return deviations (flights, names) of the vehicles of a scenario.

        scenario: its number from 0. None where they come from no airframe's uncertainty.
        """
        spec = self.scenarios[scenario].spec
        if spec.uncertainty is None:
            return None
        return drawn_numbers(spec, self.system.vehicle, self.seed, stream, range(flights))

    def loop_requirements(self) -> tuple[MarginRequirement, ...]:
        """Return the requirements on margins of single loops."""
        specs = tuple(entry.spec for entry in self.scenarios)
        requirements = [margin_requirement(table, self.system.timing, specs) for table in self.table.margin]
        return tuple(entry for entry in requirements if not entry.quantity.is_multiloop)

    def margin_model(self, state: str | None = None) -> "MarginModel":
        """Return the margins of its loop; InputError where there is no steady flight.

        state: name of one of `trims`, by default hover.
        """
        system = self.system
        (hover,) = hover_of([entry.spec for entry in self.scenarios], system.timing)
        trim = next((entry.trim for entry in self.trims if entry.name == state), hover.trim)
        return nominal_margins(system.cascade, system.nominal, system.timing, system.vehicle, trim, False)

    def read_row(self, file: Path) -> np.ndarray:
        """Return the gains row (gains,) of a file of its controller; InputError names all that differs."""
        controller = read_gains(file)
        others = differences(controller, self)
        if others:
            raise InputError(
                f"what {file} holds is not what this study flies: {'; '.join(others)}; judge the gains by a study of their own "
                "controller, or tune them for this one",
                file=self.path,
                key="controller" if "airframe" not in others[0] else "airframe",
            )
        return np.array(controller.gains)

    def earlier_gains(self, file: Path) -> EarlierGains:
        """Return the gains of a file that mean the same here; InputError where both laws are others.

        Gains in units of a firmware's output are scaled, so that the acceleration that they give stays.
        """
        controller, cascade = read_gains(file), self.system.cascade
        pairs = {loop: (getattr(controller.cascade, loop).name, getattr(cascade, loop).name) for loop in LOOPS}
        same = {loop for loop, (its, mine) in pairs.items() if its == mine}
        if not same:
            its, mine = (listing(f"{names[i]} ({loop})" for loop, names in pairs.items()) for i in range(2))
            message = f"its laws are {its}, those of this study {mine}; give a run of the same laws"
            raise InputError(message, file=file, key="controller")
        given = {
            gain.address: value
            for gain, value in zip(gain_addresses(controller.cascade), controller.gains, strict=True)
        }
        default = {
            gain.address: value for gain, value in zip(self.system.gains, self.default_row.tolist(), strict=True)
        }
        factors = {
            gain.address: _authority(given, gain) / _authority(default, gain)
            for gain in self.system.gains
            if gain.loop in same
        }
        return EarlierGains(given, factors)

    @property
    def has_shipped_front(self) -> bool:
        """Whether a shipped front has one of its searched gains."""
        cascade = self.system.cascade
        front = shipped_fronts().get((cascade.attitude.name, cascade.position.name))
        return front is not None and any(
            address in front.points[0] for variable in self.space.variables for address in variable.addresses
        )

    def shipped_front(self) -> ShippedFront:
        """Return the front of its laws that comes with the tool; InputError where there is none."""
        return shipped_front(self.system.cascade.attitude.name, self.system.cascade.position.name)

    def gains_document(self, row: np.ndarray, parts: PlainTable) -> PlainTable:
        """Return the content of gains.json for a gains row (gains,) with its parts: study, objectives, margins."""
        variables = self.space.variables
        ranges = {address: (each.low, each.high) for each in variables for address in each.addresses}
        cost = cost_rows(*[law.name for law in self.system.laws.values()])
        return to_document(self.controller(row), parts | ({"cost": cost} if cost else {}), ranges)

    def row_of(self, controller: Controller, file: Path) -> np.ndarray:  # noqa: ARG002
        """Return the gains row (gains,) of a controller."""
        return np.array(controller.gains)

    def under(self, controller: Controller, file: Path) -> Self:  # noqa: ARG002
        """Return the study under another controller, on the controller's airframe."""
        vehicle, period = controller.airframe.vehicle, controller.control_period
        knowledge = nominal(vehicle, controller.options, period)
        timing = Timing(self.system.timing.control_period, controller.plant_step)
        system = System(vehicle, controller.cascade, knowledge, self.system.limits, timing)
        return replace(self, airframe=controller.airframe, options=controller.options, system=system)

    @property
    def own_code(self) -> dict[str, dict[str, str]]:
        """Digests of the user's laws, metrics and references, by table and name."""
        kinds = {type(entry.spec.reference): None for entry in self.scenarios}
        by_table = {
            "law": origins(self.system.laws.values()),
            "metric": origins(entry.metric for entry in self.judged_metrics),
            "reference": origins(kinds, "kind"),
        }
        return {table: digests for table, digests in by_table.items() if digests}

    def _values(self) -> PlainTable:
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

    def _controller(self, without: set[str] | None = None) -> PlainTable:
        """Return every value of the controller, with the plant step as flown."""
        # A study of one rate keeps the digest that it had before there were two.
        unused = {"position_every"} if self.system.cascade.position_every == 1 else set[str]()
        values = _dumped(self.table.controller, (without or set()) | unused)
        return {**values, "plant_step": self.system.timing.plant_step}

    def _scenarios(self, paths: bool) -> list[PlainTable]:
        """Return every value of the scenarios; paths: with those of waypoint files, as given, so that folders can move."""
        return [
            {
                **_dumped(table),
                "spread": _spread_values(entry.spec, table.spread),
                "reference": _reference_values(entry.spec.reference, table.reference, paths),
            }
            for table, entry in zip(self.table.scenario, self.scenarios, strict=True)
        ]


def _authority(gains: Mapping[str, float], gain: GainAddress) -> float:
    """Return the acceleration for a unit of what a gain gives; 1 where the gain is one of accelerations."""
    return gains.get(f"{gain.axis}.authority", 1.0) if gain.info.of_output else 1.0


def _airframe_values(airframe: Airframe) -> PlainTable:
    numbers = {key: entry._asdict() for key, entry in airframe.sources.items()}
    return {"name": airframe.name, "title": airframe.title, "frame": airframe.frame, "numbers": numbers}


def _spread_values(spec: ScenarioSpec, table: Any) -> PlainTable:
    """Return the spread, or the uncertainty and its origin in its place."""
    if spec.uncertainty is None:
        return table.model_dump(mode="json", exclude={"from"})
    return {"from": getattr(table, "from"), **asdict(spec.uncertainty)}


def _reference_values(spec: ReferenceSpec, given: PlainTable, paths: bool) -> PlainTable:
    """Return kind, every parameter and the points of a waypoint file; paths: with its path as given."""
    values = {"kind": spec.kind, **asdict(spec), **{key: value for key, value in given.items() if key == "path"}}
    return {key: value for key, value in values.items() if paths or key != "path"}


def _dumped(table: StrictTable, without: set[str] | None = None) -> PlainTable:
    return table.model_dump(mode="json", by_alias=True, exclude=without)


def differences(controller: Controller, study: Study) -> list[str]:
    """Return the differences of a controller to a study.

    Each reads "NAME 'gains' instead of 'study'"; the plant step belongs to the simulation and does not count.
    """
    system, timing = study.system, study.system.timing
    pairs: list[tuple[str, object, object]] = [
        ("airframe", controller.airframe.name, study.airframe.name),
        ("position law", controller.cascade.position.name, system.cascade.position.name),
        ("attitude law", controller.cascade.attitude.name, system.cascade.attitude.name),
        ("control_period [s]", controller.control_period, timing.control_period),
        ("tilt_limit_deg", degrees(controller.options.tilt_limit), degrees(study.options.tilt_limit)),
        *[
            (key, value, getattr(study.options, key))
            for key, value in vars(controller.options).items()
            if key != "tilt_limit"
        ],
    ]
    texts = differing(pairs)
    if controller.airframe.name == study.airframe.name and controller.airframe.vehicle != study.airframe.vehicle:
        texts.insert(
            0, f"airframe '{study.airframe.name}' has other numbers in the study's file than in the gains file"
        )
    return texts
