"""The shape of a study file: which tables and keys there are, of which type, with which default.

Ranges and meanings are checked where the values are used, by the domain's own types; here a misspelt key or a text in
the place of a number is found. Lengths in m, times in s, angles in rad unless a key ends in `_deg`.
"""

from collections.abc import Mapping
from dataclasses import MISSING, fields
from types import MappingProxyType
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag, create_model

from objectives.mission import Mission
from objectives.risk import RELEVANT
from plant.air.gust import Gust
from plant.air.injection import Injection
from plant.air.spec import AirSpec
from plant.laws.slower import MAX_PERIODS
from plant.quadrotor.scenarios import Bands, Spread
from plant.quadrotor.sensors import SensorSpec
from tuner.search.names import GENERATIONS
from tuner.study import meanings
from tuner.study.certainty import CONFIDENCE, Confidence, Relevant
from tuner.study.size import MAX_FLIGHTS
from tuner.text.strict_table import StrictTable


class AirframeTable(StrictTable):
    """[airframe]: a bundled name, or a file next to the study."""

    name: str | None = None
    """A bundled airframe."""
    file: str | None = None
    """A file of your own, next to the study, in place of a name."""
    allow_unphysical: bool = False
    """Fly numbers that no real vehicle has; the airframe's file must say so too."""


class ControllerTable(StrictTable):
    """[controller]: the law of each loop, and its settings that are no gains."""

    attitude: str
    """Law of roll, pitch and yaw."""
    position: str = "ladrc"
    """Law of x, y and z."""
    control_period: float = 0.004
    """Period of the controller [s], a multiple of plant_step."""
    plant_step: float | None = None
    """Runge-Kutta step of the plant [s]; by default the control period in the fewest equal steps of at most half the
    shortest lag of the rotors."""
    position_every: Annotated[int, Field(ge=1, le=MAX_PERIODS)] = 1
    """Control periods between two steps of the position law; 4: it runs at a quarter of the rate of the attitude law."""
    attitude_rate: str = "measured"
    """Source of the rate of the attitude law: "measured", or "observer" for its own observer."""
    position_rate: str = "measured"
    """The same for the position law."""
    lag_aware: bool = True
    """Observers are fed with the modelled output of the rotors instead of the command."""
    delay: bool = False
    """A command acts one period after its measurement."""
    tilt_limit_deg: float = 30.0
    """Largest tilt that the position loop asks for [deg]."""
    yaw_torque_cutoff: float = 0.0
    """Cutoff of a low-pass on the yaw torque [Hz]; 0: none."""
    rpm_notches: int = 0
    """Harmonics of the rotors' measured speed, up to 3, at each of which a notch takes each rotor out of the gyro; 0: none."""
    rpm_notch_q: float = 5.0
    """Quality of these notches: frequency over width."""
    rpm_notch_min: float = 100.0
    """Frequency below which there are none [Hz]; from half of it above they act in full."""
    battery_compensation: float = 0.0
    """Share of the sag of the airframe's battery, 0 to 1, that commands are raised by."""
    battery_cutoff: float = 5.0
    """Cutoff of the low-pass on the voltage that this goes by [Hz]."""
    default: str | None = None
    """A gains.json whose gains stand in for the laws' defaults."""


class LimitsTable(StrictTable):
    """[limits]: a flight that leaves these has failed."""

    position: float = 5.0
    """Largest error of the position along an axis [m]."""
    tilt_deg: float = 80.0
    """Largest tilt [deg]."""


class GainTable(StrictTable):
    """A searched or tied gain; {} searches its usual range."""

    low: float | None = None
    """Lower end of the range, in the unit of the gain; by default the gain's own."""
    high: float | None = None
    """Upper end of the range; by default the gain's own."""
    scale: str | None = None
    """Scale of the range: "log" or "linear"; by default the gain's own."""
    tie: str | None = None
    """Address of another searched gain, whose value this one takes."""


def branch(text: str, table: str, other: str) -> Discriminator:
    """Discriminate by the type given, so that errors name the tag meant.

    The names of the tags end up in the error's location.
    """

    def choose(value: object) -> str:
        if isinstance(value, str):
            return text
        return table if isinstance(value, dict | GainTable) else other

    return Discriminator(choose)


NumberOrTable = Annotated[
    Annotated[float, Tag("<number>")] | Annotated[GainTable, Tag("<table>")], branch("<number>", "<table>", "<number>")
]
NumberOrText = Annotated[
    Annotated[float, Tag("<number or text>")] | Annotated[str, Tag("<text>")],
    branch("<text>", "<number or text>", "<number or text>"),
]
ListOrText = Annotated[
    Annotated[list[float], Tag("<list or text>")] | Annotated[str, Tag("<text>")],
    branch("<text>", "<list or text>", "<list or text>"),
]


def mirror(
    kind: Any, doc: str, meanings: Mapping[str, str], defaults: Mapping[str, Any] = MappingProxyType({}), **nested: Any
) -> Any:
    """Return the table of a domain dataclass: its fields, types and defaults, some of which a study has of its own; nested:
    tables of its own dataclasses.
    """
    columns: dict[str, Any] = {}
    for entry in fields(kind):
        default = defaults.get(entry.name, entry.default)
        shape = nested.get(entry.name) or _TYPES.get(str(entry.type), entry.type)
        usual = ... if default is MISSING else _listed(default)
        columns[entry.name] = (shape, Field(default=usual, description=meanings[entry.name]))
    return create_model(f"{kind.__name__}Table", __base__=StrictTable, __doc__=doc, **columns)


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


TextOrList = Annotated[
    Annotated[str, Tag("<text or list>")] | Annotated[list[str], Tag("<list>")],
    Discriminator(lambda value: "<list>" if isinstance(value, list) else "<text or list>"),
]


SensorsTable = mirror(
    SensorSpec, "[scenario.sensors]: noise and biases of what the controller measures.", meanings.SENSORS
)
# An observer that is fed with the modelled rotors knows their lag; without a spread it would know the true one.
USUAL_SPREAD = {"lag": 0.2}
# Not a name that a class could give a field.
_FROM: dict[str, Any] = {"from": (str | None, Field(default=None, description=meanings.SPREAD_FROM))}
SpreadTable = create_model(
    "SpreadTable",
    __base__=mirror(
        Spread, "[scenario.spread]: vehicles that fly, around the nominal one.", meanings.SPREAD, USUAL_SPREAD
    ),
    __doc__="[scenario.spread]: vehicles that fly, around the nominal one.",
    **_FROM,
)
BandsTable = mirror(Bands, "[scenario.bands]: bands that settling and recovery are judged by.", meanings.BANDS)
MissionTable = mirror(Mission, "[mission]: strictness of the automatic limits.", meanings.MISSION)
GustTable = mirror(Gust, "[scenario.air.gust]: one raised-cosine pulse of wind.", meanings.GUST)
InjectionTable = mirror(
    Injection, "[scenario.air.injection]: accelerations injected without air, three numbers each.", meanings.INJECTION
)
AirTable = mirror(
    AirSpec,
    "[scenario.air]: wind and turbulence.",
    meanings.AIR,
    gust=GustTable | None,
    injection=InjectionTable | None,
)


class ScenarioTable(StrictTable):
    """[[scenario]]: one kind of flight, how long, and how many draws of it the search and the held-out check fly."""

    name: str
    """Unique in the study; part of the random streams."""
    duration: float = 10.0
    """Length of a flight [s]."""
    search: Annotated[int, Field(ge=1, le=MAX_FLIGHTS)] = 32
    """Flights of each candidate in the search."""
    held_out: Annotated[int, Field(ge=2, le=MAX_FLIGHTS)] = 1024
    """Flights of a finalist in the held-out check at most, and as many for the confirmation."""
    steady_share: float = 0.2
    """Share of the flight, at its end, over which the steady-state error is taken."""
    recovery_from: float | None = None
    """Time from which recovery counts [s]; by default the end of the turbulence's window."""
    reference: dict[str, Any] = Field(default={"kind": "hover"})
    """Path to be flown: `kind` and its parameters."""
    air: AirTable = Field(default=AirTable())  # pyright: ignore[reportInvalidTypeForm]
    sensors: SensorsTable = Field(default=SensorsTable())  # pyright: ignore[reportInvalidTypeForm]
    spread: SpreadTable = Field(default=SpreadTable())  # pyright: ignore[reportInvalidTypeForm]
    bands: BandsTable = Field(default=BandsTable())  # pyright: ignore[reportInvalidTypeForm]


# resolved.json and the digest of a study keep the first names of these keys, or no recorded run would be the same study.
RECORDED_MAX, RECORDED_MIN = Field(serialization_alias="most"), Field(serialization_alias="least")


class ObjectiveTable(StrictTable):
    """[[objective]]: a metric's risk over scenarios, to be made small."""

    metric: str
    """Metric, with the axis or group of axes where it has one."""
    risk: str = "mean"
    """Risk measure over the scenarios."""
    level: float | None = None
    """Level of the risk measure, above 0 and below 1, where it has one."""
    scenario: str | None = None
    """Scenario that is judged; by default all of them."""


class ConstraintTable(ObjectiveTable):
    """[[constraint]]: the same, not to exceed `max`."""

    max: Annotated[float, RECORDED_MAX]
    """Largest value allowed, in the unit of the metric."""


class GuaranteeTable(StrictTable):
    """[[guarantee]]: a theorem that gains must satisfy before they are flown."""

    theorem: str
    """Theorem that must hold."""
    axis: str
    """Axis or group of axes."""
    max: Annotated[float | None, RECORDED_MAX] = None
    """Largest value allowed, of a theorem that bounds from above."""
    min: Annotated[float | None, RECORDED_MIN] = None
    """Smallest value allowed, of a theorem that bounds from below."""
    disturbance_rate: NumberOrText = "measured"
    """Rate of the disturbance, in the unit of the channel over s^3; "measured": from the air of the scenarios."""
    level: float = 0.99
    """Quantile of the measured rate over time and scenarios."""
    window: float | None = None
    """Time over which a change is measured [s]; by default the control period."""
    scenario: str | None = None
    """Scenario whose air is measured; by default the fastest of all."""
    hard: bool = True
    """Do not fly candidates that break it; false: a constraint like any other."""


class MarginTable(StrictTable):
    """[[margin]]: a stability margin that gains must have before they are flown; min or max, as the quantity asks."""

    quantity: str
    """Stability margin."""
    axis: str | None = None
    """Axis or group of axes; by default the worst of all six counts."""
    min: Annotated[float | None, RECORDED_MIN] = None
    """Smallest value allowed."""
    max: Annotated[float | None, RECORDED_MAX] = None
    """Largest value allowed."""
    amplitude: float = 0.0
    """Smallest amplitude of its nonlinear terms at which a loop is judged, each in its own unit; 0: small signals too."""
    at: str = "trims"
    """Steady states in which it holds: "trims", hover and the trims of the scenarios in their mean wind, or "hover" alone."""
    spread: bool = False
    """Judge the corners of the scenario's spread too."""
    hard: bool = True
    """Do not fly candidates that break it; false: a constraint like any other."""


class CostTable(StrictTable):
    """[[cost]]: what a control step may take on a microcontroller; the same for all gains of one pair of laws."""

    quantity: str
    """Quantity counted on the processor."""
    max: Annotated[float, RECORDED_MAX]
    """Largest value allowed."""
    hard: bool = True
    """Refuse a study that no gains can change; false: a constraint like any other."""


class OwnCodeTable(StrictTable):
    """[law], [metric], [reference]: Python files of your own, which run when the study is read."""

    file: TextOrList
    """A file, or a list of files, relative to the study. Each defines LAW, METRIC or REFERENCE, which the study then names."""

    @property
    def files(self) -> list[str]:
        """The files as a list."""
        return [self.file] if isinstance(self.file, str) else self.file


class StartTable(StrictTable):
    """[[search.starts]]: points by themselves, as the inputs of a run hold them."""

    origin: str = "the study"
    """Words on where the points come from."""
    points: list[dict[str, float]]
    """Values of searched gains by their keys in [gains]; one that a point leaves out has its default there."""


StartEntry = Annotated[
    Annotated[str, Tag("<path or points>")] | Annotated[StartTable, Tag("<points>")],
    Discriminator(lambda value: "<points>" if isinstance(value, dict | StartTable) else "<path or points>"),
]


class SearchTable(StrictTable):
    """[search]: how the gains are looked for."""

    algorithm: str = "auto"
    """Search algorithm; "auto": by the numbers of gains, objectives and candidates."""
    population: int | None = None
    """Candidates of a generation; by default the algorithm's own."""
    generations: Annotated[int | None, Field(ge=1)] = None
    """Number of generations, at most where the search stops once it has converged; by default the algorithm's own."""
    initial: list[str] = Field(default=["default"])
    """Points that the search starts from: "default", "design"."""
    starts: list[StartEntry] = Field(default=[])
    """Earlier runs that begin the search, with up to half of the first generation: results folders and gains.json files of the
    same laws, from the folder of the study or from the working directory, and "shipped" for the front of a pair of quadrotors'
    laws that comes with the tool. By default "shipped" where there is one and a model searches; [] for none."""
    first: Annotated[int | None, Field(ge=1)] = None
    """Flights of each scenario that every candidate makes; those that survive the search make the others. By default the
    algorithm's own."""
    reference: dict[str, Any] = Field(default={})
    """Values of objectives up to which a model searches the front, by metric; of others a tenth beyond the default, and with
    less weight on to the ends of the front."""
    flight_growth: bool | None = None
    """Whether every candidate makes more first flights where fresh ones disagree with them; by default where `first` is not given
    and a model searches."""
    stop: str = GENERATIONS
    """End of the search: "generations", or "converged" for before, where a quarter of it brought next to nothing."""
    racing: bool = True
    """Stop flying a candidate once a better one surely beats it, where all may make every flight; a model, which compares common
    flights, never races."""


class PickTable(StrictTable):
    """[pick]: rule that picks the recommended point of the front."""

    rule: str = "knee"
    """Rule of choice: "knee", "closest", "min:METRIC" or "weights". Two points have no knee and are equally close: of them the
    one with the smaller first objective is taken."""
    weights: dict[str, Any] = Field(default={})
    """Weight of each objective, where the rule is "weights"."""


class StudyTable(StrictTable):
    """A whole study file."""

    title: str
    """One line that names the study."""
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    """Root of every random number."""
    airframe: AirframeTable
    controller: ControllerTable
    target: str | None = None
    """Autopilot whose own loops fly, at its rates: "px4", "ardupilot", "betaflight", "crazyflie"; [controller] then may be left
    out."""
    scenario: Annotated[list[ScenarioTable], Field(min_length=1)]
    objective: Annotated[list[ObjectiveTable], Field(min_length=1)]
    description: str = ""
    """Text for the report."""
    confidence: Confidence = CONFIDENCE
    """Confidence of the interval whose upper end keeps each limit on flights; 0: the value alone keeps it."""
    relevant: Relevant = RELEVANT
    """Share of a value from which a difference matters: better and worse differ by more, no practical difference by less."""
    law: OwnCodeTable | None = None
    metric: OwnCodeTable | None = None
    reference: OwnCodeTable | None = None
    limits: LimitsTable = LimitsTable()
    gains: dict[str, NumberOrTable] = Field(default={})
    """Gains by address, AXIS.GAIN or GROUP.GAIN: a number fixes one, a table searches or ties it."""
    mission: MissionTable = Field(default=MissionTable())  # pyright: ignore[reportInvalidTypeForm]
    constraint: list[ConstraintTable] = Field(default=[])
    guarantee: list[GuaranteeTable] = Field(default=[])
    margin: list[MarginTable] = Field(default=[])
    cost: list[CostTable] = Field(default=[])
    search: SearchTable = SearchTable()
    pick: PickTable = PickTable()
