"""The shape of a study of a plant of the user's own: which tables and keys there are, of which type, with which default.

The parts that it shares with studies of quadrotors are in `tuner.study.schema`. Every number is in the unit that the plant's file
gives.
"""

from typing import Annotated, Any

from pydantic import Field, Tag, model_serializer

from objectives.risk import RELEVANT
from tuner.gains.channels import StudyChannelTable
from tuner.study import schema
from tuner.study.certainty import CONFIDENCE, Confidence, Relevant
from tuner.study.size import MAX_FLIGHTS
from tuner.text.strict_table import StrictTable

SignalTable = dict[str, Any]
PATIENCE = 60.0
"""Seconds of the clock on the wall that a flight of an FMU may take, unless a study gives others."""
# Keys of [plant] of which one says what the plant is; keys that count in a digest only where they are given.
PLANT_KEYS = ("file", "fmu", "transfer_function", "state_space")
LATER_KEYS = (*PLANT_KEYS[2:], "dead_time", "inputs", "outputs", "lost_beyond")


class TransferFunctionTable(StrictTable):
    """[plant] transfer_function: coefficients of polynomials in s, from the highest power down."""

    numerator: list[float]
    """Coefficients above, at most as many as below."""
    denominator: list[float]
    """Coefficients below."""


class StateSpaceTable(StrictTable):
    """[plant] state_space: x' = A x + B u, y = C x + D u, matrices by rows."""

    A: list[list[float]]
    """States by states."""
    B: list[list[float]]
    """States by inputs."""
    C: list[list[float]]
    """Outputs by states."""
    D: list[list[float]] = Field(default=[])
    """Outputs by inputs; by default 0."""


class PlantTable(StrictTable):
    """[plant]: the file of the plant, an FMU, or the numbers of a linear one, and how it is stepped."""

    file: str | None = None
    """Python file of the plant, next to the study: State, Input, Parameters, Output, derivative and output."""
    fmu: str | None = None
    """FMU for co-simulation (FMI 2 or 3) in place of a file, next to the study."""
    disturbances: list[str] = Field(default=[])
    """Inputs of an FMU that disturb it; all others are commanded."""
    transfer_function: TransferFunctionTable | None = None
    """Linear plant of one input and one output, in place of a file."""
    state_space: StateSpaceTable | None = None
    """Linear plant in place of a file."""
    dead_time: float = 0.0
    """Dead time between the inputs of a linear plant and what they do [s], whole control periods."""
    inputs: list[str] = Field(default=[])
    """Names of the inputs of a linear plant; by default "u", or "u1", "u2", ..."""
    outputs: list[str] = Field(default=[])
    """Names of its outputs; by default "y", or "y1", "y2", ..."""
    states: list[str] = Field(default=[])
    """States of an FMU for its margins, variables with a start value; by default those that it names, or else its outputs. Names
    of the states of a linear plant; by default "x1", "x2", ..."""
    units: dict[str, str] = Field(default={})
    """Units of variables for which an FMU names none, and of the signals of a linear plant; by default "1"."""
    patience: Annotated[float, Field(gt=0.0, le=86400.0)] = PATIENCE
    """Seconds of the clock on the wall after which the flight of an FMU counts as failed."""
    control_period: float
    """Period of the controller [s]."""
    plant_step: float | None = None
    """Runge-Kutta step of the plant [s], by default what its modes need, or of an FMU, by default the control period."""
    parameters: dict[str, float] = Field(default={})
    """Values in place of the nominal ones of the file."""
    lost_beyond: dict[str, Annotated[float, Field(gt=0.0)]] = Field(default={})
    """|value| from which a flight has failed, of an output or input that no channel controls, in its unit; an output that
    objectives or constraints judge needs one."""

    @property
    def is_given(self) -> bool:
        """True if the study gives the plant, and not a notebook's cell."""
        return any(getattr(self, key) is not None for key in PLANT_KEYS)

    @model_serializer(mode="wrap")
    def _without_numbers(self, handler: Any) -> dict[str, Any]:
        """Leave out later keys without values: digests stay."""
        return {key: value for key, value in handler(self).items() if key not in LATER_KEYS or value}


class ActuatorTable(StrictTable):
    """[[actuator]]: an input's way to the plant."""

    name: str
    """Input of the plant."""
    low: float | None = None
    """Lower limit of the command; by default none."""
    high: float | None = None
    """Upper limit of the command; by default none."""
    rate: float | None = None
    """How fast the command may change, in its unit per second; by default as fast as it likes."""
    delay: float = 0.0
    """Delay [s], a whole number of control periods."""
    lag: float = 0.0
    """Time constant of a first-order lag [s]; 0: none."""
    scale: float | None = None
    """Size that control activity is counted in; by default half the range, or 1 without limits."""


class PlantGainTable(schema.GainTable):
    """A searched or tied gain with its range."""

    default: float | None = None
    """Value of the default; by default the middle of the range."""


class SensorTable(StrictTable):
    """Errors of one output."""

    rms: Annotated[float, Field(ge=0.0)] = 0.0
    """White noise, rms in the unit of the output."""
    bias: Annotated[float, Field(ge=0.0)] = 0.0
    """Bias that is drawn once a flight, rms."""


class PlantScenarioTable(StrictTable):
    """[[scenario]]: one kind of flight, and how many draws of it are flown."""

    name: str
    """Name of the scenario, unique in the study."""
    duration: float
    """Length of a flight [s]."""
    search: Annotated[int, Field(ge=1, le=MAX_FLIGHTS)] = 16
    """Flights of a candidate in the search."""
    held_out: Annotated[int, Field(ge=2, le=MAX_FLIGHTS)] = 128
    """Flights of the final check, which the search never sees."""
    reference: dict[str, SignalTable] = Field(default={})
    """Signal that each outer channel follows, by its name; by default 0."""
    disturbance: dict[str, SignalTable] = Field(default={})
    """Signal of each disturbance of the plant; by default 0."""
    sensors: dict[str, SensorTable] = Field(default={})
    """Errors of each output; by default none."""
    spread: dict[str, float] = Field(default={})
    """Half-width of the uniform factor on each parameter, 0.2 for +-20 %."""
    joint_spread: Annotated[list[dict[str, float]], Field(max_length=64)] = Field(default=[])
    """Half-widths of parameters that vary together; one uniform number moves all of a table."""
    settling: float = 0.02
    """Band of the settling time, as a share of the step."""
    band: dict[str, float] = Field(default={})
    """Band of each channel that makes no step, in the unit of its output; by default a hundredth of its lost_beyond."""
    recovery_from: float = 0.0
    """Time from which recovery is counted [s]."""
    steady_share: float = 0.2
    """Share of the flight, at its end, that the steady-state error looks at."""

    @model_serializer(mode="wrap")
    def _without_joint_spread(self, handler: Any) -> dict[str, Any]:
        """Leave out a joint spread that is not given: other studies keep the digests that they had."""
        return {key: value for key, value in handler(self).items() if key != "joint_spread" or value}


NumberOrTable = Annotated[
    Annotated[float, Tag("<number>")] | Annotated[PlantGainTable, Tag("<table>")],
    schema.branch("<number>", "<table>", "<number>"),
]


class DisturbanceGainTable(StrictTable):
    """[[disturbance_gain]]: a limit on the gain from a disturbance to an output, which any loop may have."""

    disturbance: str
    """Name of a disturbance."""
    output: str
    """Name of an output."""
    max: Annotated[float, schema.RECORDED_MAX]
    """Largest gain over frequency, in units of output over disturbance."""
    hard: bool = True
    """Do not fly candidates that break it; false: a constraint like any other."""
    spread: bool = False
    """Also for plants at the corners of the scenarios' spreads; the largest gain counts."""

    @model_serializer(mode="wrap")
    def _without_spread(self, handler: Any) -> dict[str, Any]:
        """Leave out a spread that is not given: recorded studies keep their digests."""
        return {key: value for key, value in handler(self).items() if key != "spread" or value}


class ObserverTable(StrictTable):
    """[observer]: estimates of outputs without a sensor, from the model of the nominal plant."""

    measured: Annotated[list[str], Field(min_length=1)]
    """Outputs with a sensor."""
    time: float | None = None
    """Slowest time constant of the estimates' errors [s]; leave noise and input_noise out."""
    noise: dict[str, float] = Field(default={})
    """Standard deviation of each measurement, for a Kalman filter, in the unit of the output."""
    input_noise: dict[str, float] = Field(default={})
    """Standard deviation of a random value that each input adds in a control period, in its unit."""
    filtered: bool = False
    """Whether channels read estimates of the measured outputs too; an integral then removes the error of the estimate."""


class PlantStudyTable(StrictTable):
    """A whole study file of a plant of one's own."""

    title: str
    """One line that names the study."""
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    """Root of every random number."""
    plant: PlantTable
    channel: Annotated[list[StudyChannelTable], Field(min_length=1)]
    scenario: Annotated[list[PlantScenarioTable], Field(min_length=1)]
    objective: Annotated[list[schema.ObjectiveTable], Field(min_length=1)]
    gains: dict[str, NumberOrTable]
    """Gains by address, CHANNEL.GAIN: a number fixes one, a table gives its range."""
    description: str = ""
    """Text for the report."""
    confidence: Confidence = CONFIDENCE
    """Confidence of the interval whose upper end keeps each limit on flights; 0: the value alone keeps it."""
    relevant: Relevant = RELEVANT
    """Share of a value from which a difference matters: better and worse differ by more, no practical difference by less."""
    law: schema.OwnCodeTable | None = None
    metric: schema.OwnCodeTable | None = None
    actuator: list[ActuatorTable] = Field(default=[])
    mission: schema.MissionTable = Field(default=schema.MissionTable())  # pyright: ignore[reportInvalidTypeForm]
    constraint: list[schema.ConstraintTable] = Field(default=[])
    margin: list[schema.MarginTable] = Field(default=[])
    disturbance_gain: list[DisturbanceGainTable] = Field(default=[])
    observer: ObserverTable | None = None
    search: schema.SearchTable = schema.SearchTable()
    pick: schema.PickTable = schema.PickTable()
