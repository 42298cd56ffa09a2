"""The document of `tuner plan --json`: flights, time, memory, disk and precision that a run will take."""

from tuner.documents.parts import PlantStep
from tuner.store.document import Document, DocumentPart
from tuner.text.numbers import duration, ordinal


class PilotPart(DocumentPart):
    """Flights made to find out; worth_flying_percent: share of the points looked at that keep every hard requirement."""

    candidates: int
    flights: int
    seconds: float
    worth_flying_percent: float


class PlannedFlights(DocumentPart):
    """Flights of a run at most."""

    search_at_most: int
    held_out_each: int
    finalists_at_most: int
    held_out_at_most: int
    total_at_most: int


class PlannedSeconds(DocumentPart):
    """Time of a run [s].

    Args:
        compilation: Null where the kernel is there.
        search: Time of the search.
        held_out_at_most: Time of held-out check and confirmation.
        tails_at_most: Time of the estimates of rare losses.
        writing: Time of responses, figures and report.
        total_at_most: Time of all but the compilation.
    """

    compilation: float | None
    search: float
    held_out_at_most: float
    tails_at_most: float = 0.0
    writing: float
    total_at_most: float


class StreamFlights(DocumentPart):
    """Flights of the search and of the held-out check."""

    search: int
    held_out: int


class StreamWidths(DocumentPart):
    """Widths of an interval in the search and held out, null if unknown."""

    search: float | None
    held_out: float | None


class PlannedObjective(DocumentPart):
    """Expected values of an objective: its intervals."""

    label: str
    unit: str
    default: float
    flights: StreamFlights
    width: StreamWidths
    width_percent: StreamWidths
    scenarios_needed: int | None


class PlannedBound(DocumentPart):
    """Bound of a quantile that holds for any distribution (Wilks).

    Args:
        label: Label of the objective or limit.
        level: Level of the quantile.
        confidence: Confidence of the bound.
        flights: Held-out flights of the study.
        flights_needed: Flights whose largest value is the bound.
        rank: The bound is the rank-th largest value of the study's flights, null where these are too few.
    """

    label: str
    level: float
    confidence: float
    flights: int
    flights_needed: int
    rank: int | None

    @property
    def words(self) -> str:
        """Sentence for a person."""
        sure = f"{100.0 * self.confidence:g} % sure that {100.0 * self.level:g} % of flights stay below"
        place = "too few" if self.rank is None else f"whose {ordinal(self.rank)}largest value is the bound"
        return (
            f"{self.label}: {sure}: {self.flights_needed:,} flights needed (one-sided, Wilks); the study has {self.flights:,} "
            f"held out, {place}."
        )


class PlannedTail(DocumentPart):
    """Estimate of a rare loss for a limit.

    Args:
        label: Label of the limit.
        limit: Largest probability.
        method: Method that estimates it.
        flights: Flights of a point that just keeps the limit.
        seconds: Time of these [s].
        points_at_most: Points that are estimated.
    """

    label: str
    limit: float
    method: str
    flights: int
    seconds: float
    points_at_most: int

    @property
    def words(self) -> str:
        """Sentence for a person."""
        return (
            f"{self.label} at most {self.limit:g}: {self.method}, about {self.flights:,} flights in {duration(self.seconds)} for "
            f"a point, at most {self.points_at_most} points."
        )


class AutomaticLimit(DocumentPart):
    """A limit that the study does not write; key: what moves it."""

    label: str
    unit: str
    limit: float
    key: str


class PlanDocument(Document):
    """Plan of a tuning run; search: which, and why.

    difference_percent: of the default's value, that scenarios_needed are to tell.
    """

    title: str
    study: str
    digest: str
    seed: int
    threads: int
    search: str = ""
    pilot: PilotPart
    flights: PlannedFlights
    seconds: PlannedSeconds
    memory_bytes: float
    disk_bytes_at_most: float
    difference_percent: float
    objectives: list[PlannedObjective]
    bounds: list[PlannedBound] = []
    tails: list[PlannedTail] = []
    automatic_limits: list[AutomaticLimit]
    plant_step: PlantStep
    warnings: list[str]
