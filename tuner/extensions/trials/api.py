"""Studies whose trials another program makes: ask for them, submit their results, or have a function run them."""

import json
import sys
from collections.abc import Callable, Iterable, Mapping
from io import BytesIO
from pathlib import Path

from plant.errors import InputError
from plant.input_files import read_input
from plant.texts import PlainValue
from tuner.api.studies import StudyLike, loaded, of_class
from tuner.extensions.trials import asking
from tuner.extensions.trials.answers import ResultParser
from tuner.extensions.trials.asking import PendingTrials, SubmissionResult
from tuner.extensions.trials.program import TrialProcess
from tuner.extensions.trials.record import Trial, TrialContent
from tuner.extensions.trials.study import TrialStudy
from tuner.search.watcher import Watcher

STANDARD_INPUT = Path("-")
Make = Callable[[TrialContent], Mapping[str, float]]


def ask(
    study: StudyLike,
    out: str | Path | None = None,
    *,
    make: Make | None = None,
    command: str | None = None,
    timeout: float | None = None,
    watcher: Watcher | None = None,
) -> PendingTrials:
    """Return the trials that a study lacks, or have them all made.

    They are made until the study is concluded.

    Args:
        study: A study whose trials another program makes, or its file.
        out: Results folder, begun or not; by default results/NAME.
        make: Function that makes a trial: takes it as a dictionary and returns its metrics by name.
        command: Command line of a program that makes trials, as `tuner ask --run`.
        timeout: Time that the program may take over a trial [s].
        watcher: Callbacks that hear of progress.

    Returns:
        The trials lacking, none where the run was concluded, and the results folder.

    Raises:
        InputError: The study is wrong, or what was made is not what it asks for.
        StoreError: The folder is that of another study, or cannot be written.

    Examples:
        >>> pending = tuner.ask("bench.toml", "results/bench")
        >>> pending.trials[0].id, pending.trials[0].variables
        ('p0000-search-000', {'x': 1.5})

    """
    trials_study, folder = trial_study(study), None if out is None else Path(out)
    if make is not None and command is not None:
        raise InputError("given a function and a command; give one of the two", key="command")
    if command is None:
        return asking.ask(trials_study, folder, watcher, None if make is None else _made_by(make))
    with TrialProcess(command, timeout) as program:
        return asking.ask(trials_study, folder, watcher, program.run)


def tell(results: str | Path, lines: str | Path | Iterable[Mapping[str, PlainValue] | str | bytes]) -> SubmissionResult:
    """Tell a results folder what trials gave.

    Args:
        results: The results folder.
        lines: Results, each with a trial's id and its metrics or failure: dictionaries, lines of JSON, or a file of these ("-"
            for standard input).

    Returns:
        Numbers of accepted, duplicate and rejected lines, with reasons, and of pending trials.

    Raises:
        StoreError: The folder asks for no trials.
        InputError: The file cannot be read.

    Examples:
        >>> pending = tuner.ask("bench.toml", "results/told")
        >>> submission = tuner.tell("results/told", [{"id": pending.trials[0].id, "metrics": {"cost": 2.25}}])
        >>> submission.n_accepted, submission.rejected, submission.n_pending == len(pending.trials) - 1
        (1, [], True)

    """
    if not isinstance(lines, str | Path):
        return asking.tell(Path(results), map(_written, lines), "lines")
    if Path(lines) == STANDARD_INPUT:
        return asking.tell(Path(results), asking.lines_of(sys.stdin.buffer), "standard input")
    try:
        content = read_input(Path(lines))
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror}); give a file with lines of JSON, or -", file=lines
        ) from None
    return asking.tell(Path(results), asking.lines_of(BytesIO(content)), str(lines))


def _written(line: Mapping[str, PlainValue] | str | bytes) -> str | bytes:
    return line if isinstance(line, str | bytes) else json.dumps(line)


def trial_study(study: StudyLike) -> TrialStudy:
    """Return a study whose trials another program makes; InputError where it is of another kind."""
    given = loaded(study)
    refusal = (
        "this study flies by itself: `tuner run`; `tuner ask` takes one with [trials], [[variable]] and [[metric]]"
    )
    return of_class(given, TrialStudy, lambda: InputError(refusal, file=given.path))


def _made_by(make: Make) -> asking.TrialRunner:
    def made(trial: Trial, answers: ResultParser) -> None:
        metrics = dict(make(TrialContent(**trial.content())))
        answers.add(json.dumps({"id": trial.id, "metrics": metrics}), "what the function returned")

    return made
