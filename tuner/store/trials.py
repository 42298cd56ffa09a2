"""asked.jsonl and told.jsonl: the trials that another program is asked for, and what it told of each.

A line of JSON each, only ever appended, and on the disk before anything goes on. A process that is killed leaves at most a part
of a line at the end of a file, which is not read and which the next writer takes away.
"""

import json
import os
from collections.abc import Sequence
from math import isclose
from pathlib import Path
from typing import TypedDict, TypeVar

from pydantic import ValidationError

from plant.errors import StoreError
from plant.input_files import MOST_TABLE, read_input
from plant.output_files import open_in_place
from tuner.store.document import DocumentPart

# Relative difference of a variable that rounding makes on its way through the unit cube.
ROUNDING = 1e-13
REQUESTS_FILE, RESULTS_FILE = "asked.jsonl", "told.jsonl"


class TrialContent(TypedDict):
    """Trial as a function of the user's takes it; keys are the fields of `Trial`."""

    id: str
    candidate: str
    scenario: str
    seed: int
    variables: dict[str, float]


class Trial(DocumentPart):
    """A trial that is asked for.

    candidate: its name. scenario: name of what the candidate meets, the same for all candidates; seed: of that.
    """

    id: str
    candidate: str
    scenario: str
    seed: int
    variables: dict[str, float]


class Answer(DocumentPart):
    """What was told of a trial. metrics: by name, null for one that failed; reason: why it did."""

    id: str
    metrics: dict[str, float] | None = None
    failed: bool = False
    reason: str = ""


def is_same(one: Trial, other: Trial) -> bool:
    """Return true for trials that are equal but for rounding."""
    return (
        one.model_copy(update={"variables": {}}) == other.model_copy(update={"variables": {}})
        and one.variables.keys() == other.variables.keys()
        and all(isclose(value, other.variables[name], rel_tol=ROUNDING) for name, value in one.variables.items())
    )


Line = TypeVar("Line", bound=DocumentPart)


class TrialRecord:
    """The trials of a results folder. trials, answers: by id, in the order of the files."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._intact_bytes: dict[str, int] = {}
        self.trials = {trial.id: trial for trial in self._read(REQUESTS_FILE, Trial)}
        self.answers = {answer.id: answer for answer in self._read(RESULTS_FILE, Answer)}

    @property
    def lacking(self) -> list[Trial]:
        """Trials that were asked for and of which nothing was told."""
        return [trial for trial in self.trials.values() if trial.id not in self.answers]

    def ask(self, trials: list[Trial]) -> None:
        """Note trials as asked for; StoreError where other ones were asked for under the same id."""
        for trial in trials:
            before = self.trials.get(trial.id)
            if before is not None and not is_same(before, trial):
                raise StoreError(
                    f"{self._folder / REQUESTS_FILE}: {trial.id} was asked for with other values than this version or machine "
                    f"asks for; go on with the version that {self._folder / 'environment.json'} names, or begin anew with "
                    "another --out"
                )
        new = [trial for trial in trials if trial.id not in self.trials]
        self._append(REQUESTS_FILE, new)
        self.trials |= {trial.id: trial for trial in new}

    def tell(self, answer: Answer) -> None:
        """Keep what was told of a trial."""
        self._append(RESULTS_FILE, [answer])
        self.answers[answer.id] = answer

    def _read(self, name: str, kind: type[Line]) -> list[Line]:
        file = self._folder / name
        try:
            content = read_input(file, MOST_TABLE)
        except FileNotFoundError:
            return []
        except OSError as error:
            raise StoreError(
                f"{file} cannot be read ({error.strerror}); give the folder's files back to you"
            ) from error
        self._intact_bytes[name] = content.rfind(b"\n") + 1
        lines = content[: self._intact_bytes[name]].splitlines()
        return [self._parsed(file, number, line, kind) for number, line in enumerate(lines, start=1)]

    def _parsed(self, file: Path, number: int, line: bytes, kind: type[Line]) -> Line:
        try:
            return kind.model_validate_json(line)
        except ValidationError:
            raise StoreError(
                f"{file}: line {number} is damaged; take the line out, and the same `tuner ask` asks for that trial again"
            ) from None

    def _append(self, name: str, lines: Sequence[DocumentPart]) -> None:
        if not lines:
            return
        content = "".join(line_of(entry) + "\n" for entry in lines).encode()
        file = self._folder / name
        try:
            with open_in_place(file, "ab") as out:
                # What a killed process left of a line would spoil the next one.
                out.truncate(self._intact_bytes.get(name, 0))
                out.write(content)
                out.flush()
                os.fsync(out.fileno())
        except OSError as error:
            raise StoreError(
                f"{file} cannot be written ({error.strerror}); what was told before is kept. Make room, then try again"
            ) from error
        self._intact_bytes[name] = self._intact_bytes.get(name, 0) + len(content)


def line_of(entry: DocumentPart) -> str:
    """Return a line of JSON, without its end."""
    return json.dumps(entry.content(), allow_nan=False)
