"""Ask a study which trials it lacks, and tell it what they gave: each opens the results folder, adds to it and closes it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, sleep
from typing import IO

from plant.errors import HeldError, InputError, StoreError
from tuner.experiments.experiment import default_folder
from tuner.experiments.trials.answers import LONGEST_LINE, Answers
from tuner.experiments.trials.problem import UnansweredError
from tuner.experiments.trials.run import Make, TrialRun
from tuner.search.watcher import Watcher
from tuner.store.advice import RECORD, TRIALS
from tuner.store.folder import Folder
from tuner.store.inputs import RunRecord, compute_as_recorded, read_record
from tuner.store.manifest import FILE as MANIFEST
from tuner.store.manifest import read_manifest
from tuner.store.trials import Trial, TrialRecord, line_of
from tuner.study.kinds import load_any
from tuner.study.trials import TrialStudy
from tuner.text.sentences import counted

PATIENCE, PAUSE = 30.0, 0.05
"""Time [s] for which a folder that another process writes is waited for, and between two looks."""
MOST_REASONS = 1000
"""Refused lines of which the reason is kept."""
BEGUN = {".lock", MANIFEST, "generations", "inputs", "study.toml", "resolved.json", "environment.json"}
"""What a run that was killed before its run.json may have left."""


@dataclass(frozen=True)
class Asked:
    """The trials that a study lacks. path: its results folder; none are lacking where it was concluded."""

    path: Path
    trials: list[Trial]

    @property
    def concluded(self) -> bool:
        """Whether the run came to its end."""
        return not self.trials

    @property
    def lines(self) -> list[str]:
        """The trials as lines of JSON."""
        return [line_of(trial) for trial in self.trials]

    @property
    def words(self) -> str:
        """What is to be done, in a sentence."""
        if self.concluded:
            return f"All is told: {self.path / 'report.html'} has what was found; no more trials are asked for."
        trials = counted(len(self.trials), "trial")
        return f"{trials} to be made; tell what they gave with `tuner tell {self.path}`, then ask again."


@dataclass(frozen=True)
class Told:
    """What became of the lines told.

    taken, repeated: their numbers; refused: why, of the first `MOST_REASONS` of `n_refused`; lacking: trials asked for of which
    nothing was told.
    """

    taken: int
    repeated: int
    refused: list[InputError]
    n_refused: int
    lacking: int

    @property
    def words(self) -> str:
        """The numbers in a sentence, and what is to be done."""
        done = [f"{self.taken} taken", f"{self.repeated} told before", f"{self.n_refused} refused"]
        rest = f"{counted(self.lacking, 'trial')} still lacking." if self.lacking else "Nothing is lacking: ask again."
        return f"Lines: {', '.join(done)}. {rest}"


def ask(study: TrialStudy, out: Path | None, watcher: Watcher | None = None, make: Make | None = None) -> Asked:
    """Return the trials that a study lacks for the generation or check that it has come to; none where it was concluded.

    make: has them made at once, so that the run goes on to its end. Raises StoreError where the folder is that of another study.
    """
    path, watcher = out or default_folder(study), watcher or Watcher()
    if path.exists() and is_concluded(path, study):
        return Asked(path, [])
    run = TrialRun(study, opened(path, study), watcher)
    run.make = make
    try:
        run.carry_out()
    except UnansweredError as error:
        return Asked(path, error.trials)
    return Asked(path, [])


def is_concluded(path: Path, study: TrialStudy) -> bool:
    """Return whether the run of a study in a folder came to its end; StoreError where the folder is that of another study."""
    if not (path / RECORD).exists():
        return False
    check_unchanged_study(path, recorded(path), study)
    return complete(path)


def complete(path: Path) -> bool:
    """Return whether a folder was written to its end."""
    manifest = read_manifest(path)
    return manifest is not None and manifest.complete


def recorded(path: Path) -> RunRecord:
    """Return the run.json of a folder; StoreError where it is none of trials."""
    record = read_record(path)
    if record.kind != TRIALS:
        raise StoreError(f"{path} is the folder of a {record.kind}; give one that `tuner ask` made, or another --out")
    return record


def check_unchanged_study(path: Path, record: RunRecord, study: TrialStudy) -> None:
    """Refuse to go on with the folder of another study."""
    if study.digest() != record.digest:
        raise StoreError(
            f"{path} was begun with another study than {study.path} is now; give the study as it was ({path / 'study.toml'}), or "
            "another --out"
        )


def opened(path: Path, study: TrialStudy) -> Folder:
    """Return the folder of a study for writing, made where there is none yet."""
    if not path.exists():
        return Folder.create(path, inside=TrialRun.inside)
    if (path / RECORD).exists():
        compute_as_recorded(path, recorded(path), "begin anew with another --out")
    elif not path.is_dir() or not {entry.name for entry in path.iterdir()} <= BEGUN:
        return Folder.create(path, inside=TrialRun.inside)
    return waited_for(path)


def waited_for(path: Path) -> Folder:
    """Open a folder for writing, as soon as another process that asks or tells lets go of it."""
    begin = perf_counter()
    while True:
        try:
            return Folder.open(path)
        except HeldError:
            if perf_counter() - begin > PATIENCE:
                raise
            sleep(PAUSE)


def tell(path: Path, lines: Iterable[bytes | str], source: str) -> Told:
    """Take lines of JSON about trials that a folder asked for; those that cannot be used are refused, and the others taken.

    source: where the lines come from, for errors. Raises StoreError where the folder takes none.
    """
    record = recorded(path)
    if complete(path):
        raise StoreError(f"{path} was concluded and takes no more trials; what it found is in {path / 'report.html'}")
    study = load_any(path / record.study)
    assert isinstance(study, TrialStudy), "the kind of the folder says so"
    refused: list[InputError] = []
    n_refused = 0
    with waited_for(path):
        trials = TrialRecord(path)
        answers = Answers(trials, [metric.text for metric in study.metrics])
        for number, line in enumerate(lines, start=1):
            if not line.strip():
                continue
            try:
                answers.take(line, f"{source}, line {number}")
            except InputError as error:
                n_refused += 1
                if n_refused <= MOST_REASONS:
                    # With its traceback each would take some 4 kB.
                    refused.append(error.with_traceback(None))
        return Told(answers.taken, answers.repeated, refused, n_refused, len(trials.lacking))


def lines_of(source: IO[bytes]) -> Iterator[bytes]:
    """Yield lines; of one that is too long as much as tells that it is."""
    while line := source.readline(LONGEST_LINE + 2):
        yield line
        while len(line) > LONGEST_LINE and not line.endswith(b"\n"):
            line = source.readline(LONGEST_LINE + 2)
