"""summary.json: what a tuning run found."""

from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from objectives.decisions import Variable
from plant.input_files import parse_json, read_input_text
from tuner.documents.assessment import AssessmentDocument
from tuner.documents.obstacles import ConflictPart, ConstraintPrice, UnmetConstraint
from tuner.documents.parts import Estimate, LostFlight, PlantStep, ShareCount
from tuner.documents.tail import LimitedTail
from tuner.documents.verdicts import Verdict
from tuner.store.document import Document, DocumentPart, Scale, Sense
from tuner.text.numbers import count as number_text
from tuner.text.numbers import significant
from tuner.text.sentences import listing

GAINS = "gains.json"
"""File of a run's recommended gains."""
INFEASIBLE = "infeasible.json"
"""File of the nearest point's gains if nothing was feasible."""
NOTHING = "Nothing feasible"
"""Beginning of the first line on a run that recommends nothing."""


class Pick(DocumentPart):
    """Rule that picked the recommended point, and its reason in words."""

    rule: str
    why: str


class SkippedFlights(DocumentPart):
    """Candidates that were not flown, or not to the end, and the flights that this saved."""

    candidates: int
    flights: int


class SearchSeconds(DocumentPart):
    """Time of a search [s] that requirements and flights took."""

    screening: float
    flights: float


class PickedObjective(DocumentPart):
    """An objective of the recommended point in the search and held out; gap: held-out minus search."""

    label: str
    unit: str
    search: float
    held_out: Estimate
    gap: Estimate


class PointValue(DocumentPart):
    """An objective of a named point on held-out flights; difference: to the default, paired."""

    label: str
    unit: str
    held_out: Estimate
    difference: Estimate


class NamedPoint(DocumentPart):
    """A point of the front with a name; point: the finalist, "default" too; its gains are in points/NAME.json."""

    name: str
    meaning: str
    point: str
    recommended: bool = False
    objectives: list[PointValue]


class SelectionValues(DocumentPart):
    """Values that the recommended point was picked by.

    probability: share of the resamples on which it is non-dominated; lost_in_search: share of its flights in the search that it
    lost, null where it was not flown there.
    """

    probability: float
    lost_in_search: float | None = None
    objectives: list[PickedObjective]


class VariableRow(DocumentPart):
    """A searched gain; natural_ends: the ends of its range that cannot be moved."""

    name: str
    symbol: str = ""
    meaning: str = ""
    unit: str
    low: float
    high: float
    scale: Scale
    natural_ends: list[Literal["low", "high"]] = []
    default: float
    tuned: float

    def place(self, value: float) -> float:
        """Return the place of a value in the range, 0 to 1 on the range's scale."""
        return Variable(self.name, (), self.low, self.high, self.scale).unit(value)


class ComparedRow(DocumentPart):
    """An objective or constraint, default against tuned; difference: tuned minus default, paired over scenarios.

    automatic: key of the study that moves a limit which it does not write, else "". verdict of a limit: "kept" where the upper
    end of the tuned interval keeps it, at the confidence of the study, "not certain" where the value alone does. default_count,
    tuned_count: of a quantity that is 0 or 1, else null. A limit on a probability has its `tails`, by scenario.
    """

    label: str
    metric: str
    definition: str
    risk: str
    scenario: str | None = None
    unit: str
    kind: Literal["objective", "constraint"]
    limit: float | None = None
    default: Estimate
    tuned: Estimate
    difference: Estimate
    verdict: Verdict
    automatic: str = ""
    default_count: ShareCount | None = None
    tuned_count: ShareCount | None = None
    tail_flights: int | None = None
    tails: list[LimitedTail] = []
    sense: ClassVar[str] = "max"

    @property
    def evidence(self) -> tuple[str, str]:
        """Counts behind default and tuned value in words.

        Of an estimate its flights, of other values "".
        """
        default, tuned = ("" if count is None else count.words for count in (self.default_count, self.tuned_count))
        return default, tuned if self.tail_flights is None else f"by {number_text(self.tail_flights)} flights"


class ComparedState(DocumentPart):
    """A requirement in one steady state; values without intervals, null: infinite."""

    state: str
    default: float | None
    tuned: float | None

    @property
    def value(self) -> float | None:
        """The tuned value."""
        return self.tuned


class RequiredRow(DocumentPart):
    """A requirement that is known without flying; values without intervals, null: infinite.

    default_state, tuned_state: steady states in which the values are worst, null where one alone was looked at; states: each.
    """

    label: str
    quantity: str
    unit: str
    shown_unit: str | None = None
    kind: Literal["requirement"]
    limit: float
    sense: Sense
    hard: bool = True
    default: Estimate
    tuned: Estimate
    difference: Estimate
    verdict: str
    default_state: str | None = None
    tuned_state: str | None = None
    states: list[ComparedState] = []
    automatic: ClassVar[str] = ""
    evidence: ClassVar[tuple[str, str]] = ("", "")

    @property
    def worst_state(self) -> str | None:
        """The steady state in which the tuned value is worst."""
        return self.tuned_state


class AirRow(DocumentPart):
    """Turbulence of a scenario: lengths [m], deviations [m/s, rad/s] and time constants [s] by axis of the wind.

    trim_tilt [rad], trim_thrust (over the weight): of flights that start trimmed against a mean wind.
    """

    scenario: str
    spec: str = ""
    intensity: str | float = ""
    altitude: float | None = None
    mean_wind: float | None = None
    airspeed: float | None = None
    frozen_field_ratio: float | None = None
    length_u: float | None = None
    sigma_u: float | None = None
    tau_u: float | None = None
    length_v: float | None = None
    sigma_v: float | None = None
    tau_v: float | None = None
    length_w: float | None = None
    sigma_w: float | None = None
    tau_w: float | None = None
    tau_p: float | None = None
    tau_q: float | None = None
    tau_r: float | None = None
    sigma_p: float | None = None
    trim_tilt: float | None = None
    trim_thrust: float | None = None


class RaisedValue(DocumentPart):
    """An objective's value at the point shown, and where losses at their upper bound would raise it to."""

    label: str
    unit: str
    value: float
    raised: float


class UnseenLosses(DocumentPart):
    """Losses that the confirmation flights of the point shown leave room for, and what they could do to means and CVaR."""

    count: ShareCount
    objectives: list[RaisedValue]

    @property
    def words(self) -> str:
        """Both in sentences."""
        moved = [
            f"{row.label} from {significant(row.value)} to about {significant(row.raised, 3)} {row.unit}".rstrip()
            for row in self.objectives
        ]
        return (
            f"Failed flights: {self.count.words} (95 %). The intervals do not include failures that were not seen: at that bound "
            f"they would raise {listing(moved)}."
        )


TableRow = Annotated[ComparedRow | RequiredRow, Field(discriminator="kind")]


class NumberWorth(DocumentPart):
    """A number of the vehicle: by how much an objective's mean falls where it is known, and whether by more than chance.

    share: of the variance of the objective at the point shown that the number explains, shows: whether by more than chance.
    """

    name: str
    value: float
    is_significant: bool = Field(alias="told")
    share: float
    shows: bool


class UncertaintyCost(DocumentPart):
    """Loss of an objective because the vehicle is not known better, over the finalists that made all held-out flights.

    mean: of the best of them over the vehicles; known: where the best was chosen for each vehicle. told: whether they differ by
    more than chance. share: of the variance at the point shown that all numbers explain. numbers: the most valuable first.
    """

    label: str
    unit: str
    finalists: int
    flights: int
    mean: float
    mean_if_known: float = Field(alias="known")
    is_significant: bool = Field(alias="told")
    share: float
    numbers: list[NumberWorth]

    @property
    def next(self) -> NumberWorth:
        """The number to measure better next."""
        return self.numbers[0]


class Summary(Document):
    """Content of summary.json.

    tuned: the recommended point, "default" where the default stays, null where nothing is feasible; nearest: then the nearest to
    it. search: which search it was, why, and what survived it where candidates first made few flights. settled: finalists that
    made a part of their held-out flights only. points: those of the front with names. uncertainty: what each objective loses
    where vehicles are drawn from what an airframe's file leaves open. unseen: losses that no flight showed, null where some did.
    lost_flights: of default and the point shown, held out and confirmation. opinion: that of `judge` on a firmware's tuned gains
    against the present ones, added once the run has ended.
    """

    feasible: bool | None = None
    ending: list[str] = []
    title: str
    study: str
    tuned: str | None = None
    nearest: str | None = None
    pick: Pick
    search: str = ""
    flights: int
    screened: SkippedFlights | None = None
    raced: SkippedFlights | None = None
    settled: SkippedFlights | None = None
    wall_seconds: float | None = None
    search_seconds: SearchSeconds | None = None
    held_out: int
    front_size: int
    hypervolume: float
    picked_on: SelectionValues | None = None
    points: list[NamedPoint] = []
    conflict: ConflictPart | None = None
    obstacles: list[UnmetConstraint] = []
    costs: list[ConstraintPrice] = []
    remarks: list[str] = []
    warnings: list[str]
    variables: list[VariableRow]
    table: list[TableRow]
    air: list[AirRow] = []
    plant_step: PlantStep | None = None
    uncertainty: list[UncertaintyCost] = []
    unseen: UnseenLosses | None = None
    lost_flights: list[LostFlight] = []
    opinion: AssessmentDocument | None = None

    @model_validator(mode="after")
    def _names_a_point(self) -> Self:
        if self.tuned is None and self.nearest is None:
            raise ValueError("the key 'tuned' is missing")
        if self.table and not any(row.kind == "objective" for row in self.table):
            raise ValueError("'table' holds no objective")
        return self

    @property
    def recommends(self) -> bool:
        """Whether the run recommends anything; folders of earlier versions tell it by their conflict."""
        return self.conflict is None if self.feasible is None else self.feasible

    @property
    def shown(self) -> str:
        """The point that stands next to the default: the recommended one, else the nearest to feasible."""
        return str(self.nearest if self.tuned is None else self.tuned)

    @property
    def shown_as(self) -> str:
        """Name of that point at the head of a column."""
        return "tuned" if self.recommends else "nearest"

    @property
    def gains_file(self) -> str:
        """Name of the file with the gains of that point; folders of earlier versions have but one."""
        return INFEASIBLE if self.feasible is False else GAINS

    @property
    def compared(self) -> list[ComparedRow]:
        """The objectives and constraints of the table."""
        return [row for row in self.table if row.kind != "requirement"]

    @property
    def required(self) -> list[RequiredRow]:
        """The requirements of the table."""
        return [row for row in self.table if row.kind == "requirement"]


def gains_name(feasible: bool) -> str:
    """Return the name of the file that a run leaves the gains of that point in."""
    return GAINS if feasible else INFEASIBLE


def is_recommended(file: Path) -> bool:
    """Return False for a gains file that says that it is not feasible."""
    return bool(parse_json(read_input_text(file)).get("study", {}).get("feasible", True))
