"""resolved.json: every value of a study, defaults and airframe numbers included."""

import json
from typing import Self

from objectives.risk import RELEVANT
from plant.texts import PlainTable
from tuner.store.document import Document, DocumentPart, Json, Scale, Sense


class AirframeNumber(DocumentPart):
    """A number of an airframe with its origin."""

    value: float
    unit: str
    source: str


class ResolvedAirframe(DocumentPart):
    """The airframe; numbers by name."""

    name: str
    file: str | None = None
    allow_unphysical: bool = False
    title: str = ""
    frame: str = ""
    numbers: dict[str, AirframeNumber] = {}


class ResolvedController(DocumentPart):
    """Control laws by loop, periods [s] and options of the cascade."""

    attitude: str
    position: str
    control_period: float | None = None
    plant_step: float | None = None
    position_every: int = 1
    attitude_rate: str | None = None
    position_rate: str | None = None
    lag_aware: bool | None = None
    delay: bool | None = None
    tilt_limit_deg: float | None = None
    yaw_torque_cutoff: float | None = None
    rpm_notches: int = 0
    rpm_notch_q: float | None = None
    rpm_notch_min: float | None = None
    battery_compensation: float = 0.0
    battery_cutoff: float | None = None
    default: Json = None


class ResolvedPlant(DocumentPart):
    """A plant of the user's own: its file or FMU and the digest, periods [s], and parameters in the units of the file.

    disturbances, states: names of variables of an FMU; units: of those for which it names none; patience [s]. A linear plant
    has its numbers as in the study, its dead time [s] and the names of its signals.
    """

    name: str
    title: str = ""
    file: str | None = None
    fmu: str | None = None
    digest: str
    control_period: float
    plant_step: float
    disturbances: list[str] = []
    states: list[str] = []
    units: dict[str, str] = {}
    patience: float | None = None
    transfer_function: dict[str, list[float]] | None = None
    state_space: dict[str, list[list[float]]] | None = None
    dead_time: float = 0.0
    inputs: list[str] = []
    outputs: list[str] = []
    lost_beyond: dict[str, float] = {}
    parameters: dict[str, float] = {}


class ResolvedChannel(DocumentPart):
    """A loop of such a plant; limits are null where there are none."""

    name: str
    law: str
    output: str
    to: str
    b0: float = 1.0
    rate_output: str | None = None
    every: int = 1
    limit: float | None = None
    low: float | None = None
    high: float | None = None


class ResolvedStart(DocumentPart):
    """Starting points of one origin, values by variable."""

    origin: str
    points: list[dict[str, float]]


class ResolvedSearch(DocumentPart):
    """The search.

    Attributes:
        initial: Names of the points that it starts from.
        starts: Points of earlier runs.
        first: Flights of each scenario that every candidate makes, where only survivors make the others.
        flight_growth: Whether these may grow.
        reference: Values of objectives, by label, up to which the front is searched.
        why: Reason of the choice, in words.
    """

    algorithm: str
    population: int | None = None
    generations: int | None = None
    initial: list[str] | None = None
    starts: list[ResolvedStart] | None = None
    stop: str | None = None
    racing: bool | None = None
    first: int | None = None
    flight_growth: bool | None = None
    reference: dict[str, float] | None = None
    why: str = ""


class ResolvedVariable(DocumentPart):
    """A searched gain and the addresses that it represents."""

    name: str
    addresses: list[str]
    low: float
    high: float
    scale: Scale
    step: float = 0.0


class ResolvedRequirement(DocumentPart):
    """A requirement that is known without flying."""

    label: str
    quantity: str
    unit: str
    shown_unit: str | None = None
    limit: float
    sense: Sense
    hard: bool


class Resolved(Document):
    """Content of resolved.json of a tuning run; tables that are absent here are those of the study file.

    law, metric, reference: digests of code of the user's own, by name. airframe, controller: null where another thing flies: a
    plant with its actuators and channels, or trials of another program, of which variable and metric are the tables of the file.
    confidence: that limits on flights are kept with, null in folders of earlier versions, whose values alone kept them.
    relevant: share of a value from which a difference matters.
    """

    title: str = ""
    seed: int
    target: str | None = None
    law: dict[str, str] | None = None
    metric: dict[str, str] | list[dict[str, Json]] | None = None
    reference: dict[str, str] | None = None
    airframe: ResolvedAirframe | None = None
    controller: ResolvedController | None = None
    plant: ResolvedPlant | None = None
    actuator: list[dict[str, Json]] = []
    channel: list[ResolvedChannel] = []
    scenario: list[dict[str, Json]] = []
    objective: list[dict[str, Json]] = []
    description: str = ""
    limits: dict[str, Json] = {}
    gains: dict[str, float] = {}
    mission: dict[str, Json] | None = None
    confidence: float | None = None
    relevant: float = RELEVANT
    constraint: list[dict[str, Json]] = []
    guarantee: list[dict[str, Json]] = []
    margin: list[dict[str, Json]] = []
    disturbance_gain: list[dict[str, Json]] = []
    observer: dict[str, Json] | None = None
    cost: list[dict[str, Json]] = []
    search: ResolvedSearch
    pick: dict[str, Json] = {}
    variables: list[ResolvedVariable] = []
    variable: list[dict[str, Json]] = []
    trials: dict[str, Json] | None = None
    requirements: list[ResolvedRequirement] = []
    digest: str = ""

    @classmethod
    def of(cls, values: PlainTable) -> Self:
        """Return the document of the values of a study."""
        return cls.parse(json.dumps(values, allow_nan=False))
