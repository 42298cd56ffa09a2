"""Documents and folders of contests: contest.json, the plan of one, and the progress of one that is not finished."""

from pathlib import Path
from typing import Literal

from tuner.documents.comparison import ComparedFolder
from tuner.documents.comparison_document import ComparedDocument
from tuner.documents.plan import PlanDocument
from tuner.store.advice import CONTEST
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


class UnfinishedContest(DocumentPart):
    """A contest in progress: contenders whose tuning has ended, and those whose tuning has begun."""

    kind: str
    finished: Literal[False]
    title: str
    contenders_finished: list[str]
    contenders_begun: list[str]
    commands: list[str]

    @property
    def texts(self) -> list[str]:
        """Sentences on its progress."""
        return [
            f"Tuned: {', '.join(self.contenders_finished) or 'none'}",
            f"Begun: {', '.join(self.contenders_begun) or 'none'}",
        ]


def contest_progress(folder: Path, title: str, commands: list[str]) -> UnfinishedContest:
    """Return the progress of a contest; commands: that go on with it."""
    contenders = sorted(path for path in folder.glob("contenders/*") if path.is_dir())
    done = [path.name for path in contenders if (path / "summary.json").exists()]
    return UnfinishedContest(
        kind=CONTEST,
        finished=False,
        title=title,
        contenders_finished=done,
        contenders_begun=[path.name for path in contenders if path.name not in done],
        commands=commands,
    )
