"""The shape of a study file: which tables and keys there are, of which type, with which default.

Ranges and meanings are checked where the values are used, by the domain's own types; here a misspelt key or a text in
the place of a number is found. Lengths in m, times in s, angles in rad unless a key ends in `_deg`.
"""

from collections.abc import Mapping
from dataclasses import MISSING, fields
from types import MappingProxyType
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, create_model

from objectives.mission import Mission
from plant.air.gust import Gust
from plant.air.injection import Injection
from plant.air.spec import AirSpec
from plant.scenarios import Bands, Spread
from plant.sensors import SensorSpec
from tuner.study.size import MOST_FLIGHTS


class Table(BaseModel):
    """A table that knows all its keys and does not turn one type into another."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class AirframeTable(Table):
    """[airframe]: a bundled name, or a file beside the study."""

    name: str | None = None
    file: str | None = None
    allow_unphysical: bool = False


class ControllerTable(Table):
    """[controller]: the law of each loop and what is no gain; default: a gains.json that stands in for the laws' defaults."""

    attitude: str
    position: str = "ladrc"
    control_period: float = 0.004
    plant_step: float = 0.001
    attitude_rate: str = "measured"
    position_rate: str = "measured"
    lag_aware: bool = True
    delay: bool = False
    tilt_limit_deg: float = 30.0
    yaw_torque_cutoff: float = 0.0
    default: str | None = None


class LimitsTable(Table):
    """[limits]: a flight that leaves these has failed."""

    position: float = 5.0
    tilt_deg: float = 80.0


class GainTable(Table):
    """A searched or tied gain: range and scale, by default the gain's own; or tie = another entry's key."""

    low: float | None = None
    high: float | None = None
    scale: str | None = None
    tie: str | None = None


def _branch(text: str, table: str, other: str) -> Discriminator:
    """Decide by the type given, so that errors speak of what was meant; the names end up in the error's location."""

    def choose(value: object) -> str:
        if isinstance(value, str):
            return text
        return table if isinstance(value, dict | GainTable) else other

    return Discriminator(choose)


NumberOrTable = Annotated[
    Annotated[float, Tag("<number>")] | Annotated[GainTable, Tag("<table>")], _branch("<number>", "<table>", "<number>")
]
NumberOrText = Annotated[
    Annotated[float, Tag("<number or text>")] | Annotated[str, Tag("<text>")],
    _branch("<text>", "<number or text>", "<number or text>"),
]
ListOrText = Annotated[
    Annotated[list[float], Tag("<list or text>")] | Annotated[str, Tag("<text>")],
    _branch("<text>", "<list or text>", "<list or text>"),
]


def mirror(kind: Any, doc: str, defaults: Mapping[str, Any] = MappingProxyType({}), **nested: Any) -> Any:
    """Return the table of a domain dataclass: its fields, types and defaults, some of which a study has of its own; nested:
    tables of its own dataclasses.
    """
    columns: dict[str, Any] = {}
    for entry in fields(kind):
        default = defaults.get(entry.name, entry.default)
        shape = nested.get(entry.name) or _TYPES.get(str(entry.type), entry.type)
        columns[entry.name] = (shape, ... if default is MISSING else _listed(default))
    return create_model(f"{kind.__name__}Table", __base__=Table, __doc__=doc, **columns)


# Tuples are lists in TOML.
_TYPES: dict[str, Any] = {
    "plant.air.injection.Triple": list[float],
    "tuple[float, ...]": list[float],
    "tuple[str, ...]": list[str],
    "tuple[float, float] | None": list[float] | None,
    "str | tuple[float, ...]": ListOrText,
    "str | float": NumberOrText,
}


def _listed(default: Any) -> Any:
    return list(default) if isinstance(default, tuple) else default


SensorsTable = mirror(SensorSpec, "[scenario.sensors]")
# An observer that is fed with the modelled rotors knows their lag; without a spread it would know the true one.
USUAL_SPREAD = {"lag": 0.2}
SpreadTable = mirror(Spread, "[scenario.spread]", USUAL_SPREAD)
BandsTable = mirror(Bands, "[scenario.bands]")
MissionTable = mirror(Mission, "[mission]: how much the automatic limits ask.")
GustTable = mirror(Gust, "[scenario.air.gust]")
InjectionTable = mirror(Injection, "[scenario.air.injection]")
AirTable = mirror(AirSpec, "[scenario.air]", gust=GustTable | None, injection=InjectionTable | None)


class ScenarioTable(Table):
    """[[scenario]]: one kind of flight, how long, and how many draws of it the search and the held-out check fly."""

    name: str
    duration: float = 10.0
    search: Annotated[int, Field(ge=1, le=MOST_FLIGHTS)] = 32
    held_out: Annotated[int, Field(ge=2, le=MOST_FLIGHTS)] = 1024
    steady_share: float = 0.2
    recovery_from: float | None = None
    reference: dict[str, Any] = Field(default={"kind": "hover"})
    air: AirTable = Field(default=AirTable())  # pyright: ignore[reportInvalidTypeForm]
    sensors: SensorsTable = Field(default=SensorsTable())  # pyright: ignore[reportInvalidTypeForm]
    spread: SpreadTable = Field(default=SpreadTable())  # pyright: ignore[reportInvalidTypeForm]
    bands: BandsTable = Field(default=BandsTable())  # pyright: ignore[reportInvalidTypeForm]


class ObjectiveTable(Table):
    """[[objective]]: a metric's risk over scenarios, to be made small."""

    metric: str
    risk: str = "mean"
    level: float | None = None
    scenario: str | None = None


class ConstraintTable(ObjectiveTable):
    """[[constraint]]: the same, not to exceed `most`."""

    most: float


class GuaranteeTable(Table):
    """[[guarantee]]: a theorem that gains must satisfy before they are flown."""

    theorem: str
    axis: str
    most: float | None = None
    least: float | None = None
    disturbance_rate: NumberOrText = "measured"
    level: float = 0.99
    window: float | None = None
    scenario: str | None = None
    hard: bool = True


class MarginTable(Table):
    """[[margin]]: a stability margin that gains must have before they are flown; least or most, as the quantity asks."""

    quantity: str
    axis: str | None = None
    least: float | None = None
    most: float | None = None
    amplitude: float = 0.0
    spread: bool = False
    hard: bool = True


class CostTable(Table):
    """[[cost]]: what a control step may take on a microcontroller; the same for all gains of one pair of laws."""

    quantity: str
    most: float
    hard: bool = True


class SearchTable(Table):
    """[search]: how the gains are looked for."""

    algorithm: str = "nsga2"
    population: int = 48
    generations: Annotated[int, Field(ge=1)] = 15
    initial: list[str] = Field(default=["default"])
    racing: bool = True


class PickTable(Table):
    """[pick]: which point of the front is recommended; weights: by objective, for rule = "weights"."""

    rule: str = "knee"
    weights: dict[str, Any] = Field(default={})


class StudyTable(Table):
    """A whole study file."""

    title: str
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    airframe: AirframeTable
    controller: ControllerTable
    scenario: Annotated[list[ScenarioTable], Field(min_length=1)]
    objective: Annotated[list[ObjectiveTable], Field(min_length=1)]
    description: str = ""
    limits: LimitsTable = LimitsTable()
    gains: dict[str, NumberOrTable] = Field(default={})
    mission: MissionTable = Field(default=MissionTable())  # pyright: ignore[reportInvalidTypeForm]
    constraint: list[ConstraintTable] = Field(default=[])
    guarantee: list[GuaranteeTable] = Field(default=[])
    margin: list[MarginTable] = Field(default=[])
    cost: list[CostTable] = Field(default=[])
    search: SearchTable = SearchTable()
    pick: PickTable = PickTable()
