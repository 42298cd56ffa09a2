"""Progress of a contest whose folder is not finished."""

from pathlib import Path
from typing import Literal

from tuner.store.advice import CONTEST
from tuner.store.document import DocumentPart


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
        """How far it came, in sentences."""
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
