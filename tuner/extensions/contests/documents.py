"""Documents and folders of contests: contest.json, and the plan of one."""

from tuner.documents.comparison import ComparedFolder
from tuner.documents.comparison_document import ComparedDocument
from tuner.documents.plan import PlanDocument
from tuner.store.document import Document, DocumentPart


class ContestDocument(ComparedDocument):
    """Content of contest.json.

    feasible: whether every contender's run recommends its point; ending: if not, what to tell first. stream: of the scenarios
    compared on. words: all of it in sentences.
    """


class ContestFolder(ComparedFolder[ContestDocument]):
    """Results of a contest."""

    kind, noun, main, model = "contest", "a contest", "contest.json", ContestDocument


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
