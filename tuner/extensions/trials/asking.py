"""Ask and tell: pending trials of a study, and submission of their results; each opens, extends and closes its folder."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, sleep
from typing import IO, cast

from plant.errors import FolderLockedError, InputError, StoreError
from tuner.experiments.experiment import default_folder
from tuner.extensions.step_records.json_lines import line_of
from tuner.extensions.trials.answers import MAX_LINE_BYTES, ResultParser
from tuner.extensions.trials.problem import MissingResultError
from tuner.extensions.trials.record import Trial, TrialRecord
from tuner.extensions.trials.run import TrialRun, TrialRunner
from tuner.extensions.trials.study import TrialStudy
from tuner.search.watcher import Watcher, default_watcher
from tuner.store.advice import RECORD, TRIALS
from tuner.store.folder import Folder
from tuner.store.inputs import RunRecord, compute_as_recorded, read_record
from tuner.store.manifest import FILE as MANIFEST
from tuner.store.manifest import read_manifest
from tuner.study.kinds import load_any
from tuner.text.sentences import counted

LOCK_TIMEOUT = 30.0
"""Time to wait for a folder that another process has locked [s]."""
PAUSE = 0.05
"""Time between two attempts [s]."""
MAX_REASONS = 1000
"""Rejected lines whose reason is recorded."""
BEGUN = {".lock", MANIFEST, "generations", "inputs", "study.toml", "resolved.json", "environment.json"}
"""Files of a run that was killed before its run.json."""


@dataclass(frozen=True)
class PendingTrials:
    """Pending trials of a study, none where it was concluded. path: its results folder."""

    path: Path
    trials: list[Trial]

    @property
    def is_concluded(self) -> bool:
        """True where the run came to its end."""
        return not self.trials

    @property
    def lines(self) -> list[str]:
        """The trials as lines of JSON."""
        return [line_of(trial) for trial in self.trials]

    @property
    def words(self) -> str:
        """The next step, in a sentence."""
        if self.is_concluded:
            return f"All results are in; see {self.path / 'report.html'}."
        trials = counted(len(self.trials), "trial")
        return f"{trials} pending; submit the results with `tuner tell {self.path}`, then run `tuner ask` again."


@dataclass(frozen=True)
class SubmissionResult:
    """Numbers of accepted, duplicate and rejected lines and of pending trials; rejected: the first `MAX_REASONS` errors."""

    n_accepted: int
    n_duplicates: int
    rejected: list[InputError]
    n_rejected: int
    n_pending: int

    @property
    def words(self) -> str:
        """The numbers in a sentence, and the next step."""
        done = [f"{self.n_accepted} accepted", f"{self.n_duplicates} duplicate", f"{self.n_rejected} rejected"]
        rest = f"{counted(self.n_pending, 'trial')} pending." if self.n_pending else "Complete: run `tuner ask` again."
        return f"Lines: {', '.join(done)}. {rest}"


def ask(
    study: TrialStudy, out: Path | None, watcher: Watcher | None = None, make: TrialRunner | None = None
) -> PendingTrials:
    """Return the pending trials of a study's next generation or check; none where it was concluded.

    make: runs each trial at once, so that the run goes on to its end. Raises StoreError for the folder of another study.
    """
    path, watcher = out or default_folder(study), watcher or default_watcher()
    if path.exists() and is_concluded(path, study):
        return PendingTrials(path, [])
    run = TrialRun(study, open_or_create(path, study), watcher)
    run.make = make
    try:
        run.carry_out()
    except MissingResultError as error:
        return PendingTrials(path, error.trials)
    return PendingTrials(path, [])


def is_concluded(path: Path, study: TrialStudy) -> bool:
    """Return true where the run in a folder came to its end; StoreError where it is that of another study."""
    if not (path / RECORD).exists():
        return False
    check_unchanged_study(path, recorded(path), study)
    return is_complete(path)


def is_complete(path: Path) -> bool:
    """Return true for a complete folder."""
    manifest = read_manifest(path)
    return manifest is not None and manifest.complete


def recorded(path: Path) -> RunRecord:
    """Return the run.json of a folder; StoreError where it is none of trials."""
    record = read_record(path)
    if record.kind != TRIALS:
        raise StoreError(f"{path} is the folder of a {record.kind}; give one that `tuner ask` made, or another --out")
    return record


def check_unchanged_study(path: Path, record: RunRecord, study: TrialStudy) -> None:
    """Raise StoreError for the folder of another study."""
    if study.digest() != record.digest:
        raise StoreError(
            f"{path} was begun with another study than {study.path} is now; give the study as it was ({path / 'study.toml'}), or "
            "another --out"
        )


def open_or_create(path: Path, study: TrialStudy) -> Folder:
    """Return the folder of a study for writing, created if missing."""
    if not path.exists():
        return Folder.create(path, inside=TrialRun.inside)
    if (path / RECORD).exists():
        compute_as_recorded(path, recorded(path), "start over with another --out")
    elif not path.is_dir() or not {entry.name for entry in path.iterdir()} <= BEGUN:
        return Folder.create(path, inside=TrialRun.inside)
    return open_when_unlocked(path)


def open_when_unlocked(path: Path) -> Folder:
    """Open a folder for writing, as soon as another process releases it."""
    begin = perf_counter()
    while True:
        try:
            return Folder.open(path)
        except FolderLockedError:
            if perf_counter() - begin > LOCK_TIMEOUT:
                raise
            sleep(PAUSE)


def tell(path: Path, lines: Iterable[bytes | str], source: str) -> SubmissionResult:
    """Record results of pending trials from lines of JSON; invalid lines are rejected one by one.

    source: of the lines, for errors. Raises StoreError where the folder takes none.
    """
    record = recorded(path)
    if is_complete(path):
        raise StoreError(f"{path} was concluded and takes no more trials; what it found is in {path / 'report.html'}")
    # The kind of the folder says which it is.
    study = cast(TrialStudy, load_any(path / record.study))
    rejected: list[InputError] = []
    n_rejected = 0
    with open_when_unlocked(path):
        trials = TrialRecord(path)
        answers = ResultParser(trials, [metric.text for metric in study.metrics])
        for number, line in enumerate(lines, start=1):
            if not line.strip():
                continue
            try:
                answers.add(line, f"{source}, line {number}")
            except InputError as error:
                n_rejected += 1
                if n_rejected <= MAX_REASONS:
                    # With its traceback each would take some 4 kB.
                    rejected.append(error.with_traceback(None))
        return SubmissionResult(answers.n_accepted, answers.n_duplicates, rejected, n_rejected, len(trials.lacking))


def lines_of(source: IO[bytes]) -> Iterator[bytes]:
    """Yield lines, too long ones truncated just beyond the limit."""
    while line := source.readline(MAX_LINE_BYTES + 2):
        yield line
        while len(line) > MAX_LINE_BYTES and not line.endswith(b"\n"):
            line = source.readline(MAX_LINE_BYTES + 2)
