"""The document of `tuner plan --json`: flights, time, memory, disk and precision that a run will take."""

from tuner.documents.parts import PlantStep
from tuner.store.document import Document, DocumentPart


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
    """Time of a run [s]; compilation: null where the kernel is there."""

    compilation: float | None
    search: float
    held_out_at_most: float
    writing: float
    total_at_most: float


class StreamFlights(DocumentPart):
    """Flights of the search and of the held-out check."""

    search: int
    held_out: int


class StreamWidths(DocumentPart):
    """Widths of an interval in the search and held out, null where nothing can be said."""

    search: float | None
    held_out: float | None


class PlannedObjective(DocumentPart):
    """What to expect of an objective: its intervals."""

    label: str
    unit: str
    default: float
    flights: StreamFlights
    width: StreamWidths
    width_percent: StreamWidths
    scenarios_needed: int | None


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
    automatic_limits: list[AutomaticLimit]
    plant_step: PlantStep
    warnings: list[str]


class PlannedComparison(DocumentPart):
    """The comparison of a contest, at most."""

    stream: str
    flights_each: int
    points_at_most: int
    flights_at_most: int
    seconds_at_most: float


class PlannedTotal(DocumentPart):
    """All of a contest, at most."""

    flights_at_most: int
    seconds_at_most: float
    compilation_seconds: float | None
    memory_bytes: float | None
    disk_bytes_at_most: float


class ContestPlanDocument(Document):
    """Plan of a contest; runs: of the contenders that are tuned, by name."""

    title: str
    study: str
    digest: str
    seed: int
    runs: dict[str, PlanDocument]
    comparison: PlannedComparison
    total: PlannedTotal
