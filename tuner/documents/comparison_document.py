"""Documents of contenders on the same flights, in numbers and sentences. Intervals are of 95 %, over flights."""

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from tuner.documents.parts import Estimate, GainValue, LawNames, ShareCount
from tuner.documents.verdicts import Verdict as DifferenceVerdict
from tuner.store.document import Document, DocumentPart, OneOf


class ComparedOn(DocumentPart):
    """A scenario of the comparison: flights of each contender, and how long one lasts [s]."""

    scenario: str
    flights: int
    duration: float


class ContenderPick(DocumentPart):
    """Rule that picked the point of a contender, null where its gains are given, and the reason in words."""

    rule: str | None
    why: str


class SearchBudget(DocumentPart):
    """Size of a contender's search."""

    population: int
    generations: int
    flights: int


class ProcessorCount(DocumentPart):
    """Instructions and bytes of a control step on a microcontroller; instructions are means, most_: the largest seen."""

    target: str
    instructions_attitude: float
    most_attitude: int
    instructions_step: float
    most_step: int
    text_bytes: int
    state_bytes: int
    stack_bytes: int
    compiler: str
    emulator: str
    flags: str
    instructions_per_second: float
    meaning: str


class StepCost(DocumentPart):
    """Operations of the laws in one control step, of an axis of each loop or of each channel of a plant of the user's own.

    processor: null for a law younger than the packaged table.
    """

    operations: int
    position: int | None = None
    attitude: int | None = None
    channels: dict[str, int] | None = None
    meaning: str
    processor: ProcessorCount | None = None


class BoundRow(DocumentPart):
    """A variable near an end of its range.

    recommended: the point compared is there; share: of the front's points that are; natural: the gain means nothing beyond.
    """

    variable: str
    end: Literal["low", "high"]
    bound: float
    value: float
    recommended: bool
    share: float
    natural: bool


class ContenderRow(DocumentPart):
    """One controller as it flew.

    folder: of its own results, null for none; point: of its own study, or "given"; searched: variables that a search chose;
    failures: share of its flights. source, kind: where it came from, of a comparison alone. laws, airframe: of a quadrotor;
    plant, channels: of a plant of the user's own, with the law of each channel.
    """

    name: str
    slug: str
    laws: LawNames | None = None
    airframe: str | None = None
    plant: str | None = None
    channels: dict[str, str] | None = None
    tuned: bool
    feasible: bool = True
    folder: str | None = None
    point: str
    pick: ContenderPick | None = None
    budget: SearchBudget | None = None
    gains: dict[str, GainValue]
    searched: list[str] = []
    cost: StepCost
    on_bounds: list[BoundRow]
    failures: float
    source: str | None = None
    kind: Literal["gains", "results"] | None = None

    @property
    def flown(self) -> str:
        """Name of the airframe or the plant that flew."""
        return self.airframe or self.plant or ""

    @property
    def law_of(self) -> dict[str, str]:
        """Law by loop: attitude and position, or the channels of a plant."""
        return {"attitude": self.laws.attitude, "position": self.laws.position} if self.laws else self.channels or {}


class RungRow(DocumentPart):
    """A contender at a rung of successive halving.

    Attributes:
        generations, flights: Of its search so far.
        feasible: A candidate keeps all limits.
        share: Of the common box, dominated by its front of search flights.
    """

    rung: int
    contender: str
    generations: int
    flights: int
    feasible: bool
    share: float
    goes_on: bool


class QuantityRow(DocumentPart):
    """A number that is compared; smaller is better; limit: what it must not exceed."""

    label: str
    metric: str
    unit: str
    risk: str
    level: float | None = None
    scenario: str | None = None
    definition: str
    risk_definition: str = ""
    kind: Annotated[str, OneOf(("objective", "constraint", "published", "claimed"))] = "objective"
    limit: float | None = None

    @property
    def risk_text(self) -> str:
        """Definition of the risk; its name in folders of earlier versions."""
        return self.risk_definition or self.risk


class _WithInterval(DocumentPart):
    middle: ClassVar[str] = "value"

    @property
    def estimate(self) -> Estimate:
        """The number with its interval."""
        return Estimate(*[getattr(self, name) for name in (self.middle, "low", "high")])


class EstimateRow(_WithInterval):
    """The value of a quantity for a contender; count: of a quantity that is 0 or 1."""

    contender: str
    quantity: str
    value: float
    low: float
    high: float
    count: ShareCount | None = None


class DifferenceRow(_WithInterval):
    """Second minus first contender on the same flights.

    lower: the better one by the rule of `objectives.risk.differences`, else null; verdict then is the rule's word.
    """

    middle = "difference"
    first: str
    second: str
    quantity: str
    difference: float
    low: float
    high: float
    verdict: DifferenceVerdict
    lower: str | None


class FrontSize(DocumentPart):
    """Points of a front; broken: how many more of the held-out front break a constraint on these flights."""

    contender: str
    points: int
    broken: int = 0


class VolumeRow(_WithInterval):
    """Share of the common box that the front of a contender dominates."""

    contender: str
    value: float
    low: float
    high: float


class VolumeDifference(DocumentPart):
    """Share of the second front minus that of the first, paired; larger: whose, null where the rule shows neither."""

    first: str
    second: str
    difference: float
    low: float
    high: float
    larger: str | None


class FrontsPart(DocumentPart):
    """Box from ideal to reference by objective, and what the fronts have of it."""

    objectives: list[str]
    ideal: dict[str, float]
    reference: dict[str, float]
    meaning: str = ""
    sizes: list[FrontSize]
    hypervolume: list[VolumeRow]
    differences: list[VolumeDifference]

    @model_validator(mode="after")
    def _box_is_whole(self) -> Self:
        missing = [label for label in self.objectives if label not in self.reference]
        if missing:
            raise ValueError(f"the key 'fronts.reference.{missing[0]}' is missing")
        return self

    def size(self, contender: str) -> int:
        """Return the number of points of a front."""
        return next((row.points for row in self.sizes if row.contender == contender), 0)

    def even_with(self, contender: str) -> set[str]:
        """Return the contenders whose front the paired difference does not tell apart from this one."""
        pairs = [{row.first, row.second} for row in self.differences if row.larger is None]
        return {name for pair in pairs if contender in pair for name in pair - {contender}}


class BestRow(_WithInterval):
    """The point of a front that is best in an objective while it keeps a limit in another; null where none keeps it."""

    contender: str
    value: float | None
    low: float | None
    high: float | None
    point: str | None


class BestUnder(DocumentPart):
    """Offer of every front under a limit: the smallest `objective` with `subject_to` at most `limit`."""

    objective: str
    subject_to: str
    limit: float
    rows: list[BestRow]


class PublishedRow(DocumentPart):
    """A printed number beside our flights: their mean with its interval, and their 2.5, 50 and 97.5 % points.

    percentile: share of our flights below the printed number [%]; inside: it lies between 2.5 and 97.5; fitted: the study was
    set to meet it, so meeting it says nothing.
    """

    contender: str
    contenders: list[str]
    metric: str
    unit: str
    scenario: str
    quantity: str
    printed: float = Field(alias="value")
    source: str = ""
    fitted: bool = False
    mean: float
    low: float
    high: float
    p2_5: float
    median: float
    p97_5: float
    percentile: float
    inside: bool

    @property
    def central(self) -> Estimate:
        """Median with the central 95 % of our flights."""
        return Estimate(self.median, self.p2_5, self.p97_5)


Verdict = Annotated[str, OneOf(("survives", "fails", "undecided"))]


class RulingRow(_WithInterval):
    """A claim for one opponent in one quantity; difference: claimed better minus opponent."""

    middle = "difference"
    than: str
    quantity: str
    difference: float
    low: float
    high: float
    verdict: Verdict


class ClaimRow(DocumentPart):
    """A sentence put to the test, its verdict, and the comparisons behind it.

    basis: quantities of the claim, and by how much others differ at the points compared.
    """

    text: str
    basis: str = ""
    better: str
    than: list[str]
    verdict: Verdict
    rows: list[RulingRow]


class _Ending(DocumentPart):
    feasible: bool = True
    ending: list[str] = []


class ComparedDocument(_Ending, Document):
    """Content of the document of contenders on the same flights."""

    title: str
    description: str = ""
    study: str
    seed: int
    flights: int
    stream: str = ""
    compared_on: list[ComparedOn]
    wall_seconds: float
    contenders: list[ContenderRow]
    quantities: list[QuantityRow]
    estimates: list[EstimateRow]
    differences: list[DifferenceRow]
    fronts: FrontsPart | None = None
    best_under: list[BestUnder]
    published: list[PublishedRow]
    claims: list[ClaimRow] = []
    rungs: list[RungRow] = []
    words: list[str]
    warnings: list[str]


class _Compared(DocumentPart):
    kind: Literal["comparison"]
    first: str
    study_file: str
    front_points_at_most: int


class ComparisonDocument(ComparedDocument, _Compared, _Ending, Document):
    """Content of comparison.json: that of a contest, with what the others are compared to and where scenarios came from."""
