"""asked.jsonl and told.jsonl: the trials that another program is asked for, and what it told of each.

A line of JSON each, see `tuner.extensions.step_records.json_lines`.
"""

from math import isclose
from pathlib import Path
from typing import TypedDict

from plant.errors import StoreError
from tuner.extensions.step_records.json_lines import JsonLines
from tuner.store.document import DocumentPart

# Relative difference of a variable that rounding makes on its way through the unit cube.
ROUNDING = 1e-13
REQUESTS_FILE, RESULTS_FILE = "asked.jsonl", "told.jsonl"
ADVICE = "take the line out, and the same `tuner ask` asks for that trial again"


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
    """Result of a trial. metrics: by name, null for one that failed; reason: why it did."""

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


class TrialRecord:
    """The trials of a results folder. trials, answers: by id, in the order of the files."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._requests = JsonLines(folder / REQUESTS_FILE, Trial, ADVICE)
        self._results = JsonLines(folder / RESULTS_FILE, Answer, ADVICE)
        self.trials = {trial.id: trial for trial in self._requests.lines}
        self.answers = {answer.id: answer for answer in self._results.lines}

    @property
    def lacking(self) -> list[Trial]:
        """Trials without a result."""
        return [trial for trial in self.trials.values() if trial.id not in self.answers]

    def ask(self, trials: list[Trial]) -> None:
        """Note trials as asked for; StoreError where other ones were asked for under the same id."""
        for trial in trials:
            before = self.trials.get(trial.id)
            if before is not None and not is_same(before, trial):
                raise StoreError(
                    f"{self._folder / REQUESTS_FILE}: the recorded {trial.id} has other values than this version or machine "
                    f"computes; use the version in {self._folder / 'environment.json'}, or start over with "
                    "another --out"
                )
        new = [trial for trial in trials if trial.id not in self.trials]
        self._requests.append(new)
        self.trials |= {trial.id: trial for trial in new}

    def tell(self, answer: Answer) -> None:
        """Add the result of a trial."""
        self._results.append([answer])
        self.answers[answer.id] = answer
