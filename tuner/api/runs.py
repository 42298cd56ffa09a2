"""Commands of runs: start, resume, repeat and judge again."""

from collections.abc import Mapping
from pathlib import Path
from typing import Unpack, overload

from plant.texts import PlainValue
from tuner.api.opinion import end_with_opinion
from tuner.api.results import AnyResults, TuningResults, open_results
from tuner.api.studies import StudyLike, loaded
from tuner.documents.tuning import TuningFolder
from tuner.experiments import registry
from tuner.experiments.again import rejudge as judging
from tuner.experiments.again import resume as resuming
from tuner.experiments.again import verify as verification
from tuner.experiments.options import ResumeOptions, RunOptions, with_options
from tuner.search.watcher import Watcher, default_watcher
from tuner.study.files import study_file
from tuner.study.searched import SearchedStudy

PathLike = str | Path


@overload
def run(
    study: SearchedStudy, out: PathLike | None = None, *, watcher: Watcher | None = None, **options: Unpack[RunOptions]
) -> TuningResults: ...
@overload
def run(
    study: StudyLike, out: PathLike | None = None, *, watcher: Watcher | None = None, **options: Unpack[RunOptions]
) -> AnyResults: ...
@with_options(RunOptions, lambda _, hint, option: hint)
def run(
    study: StudyLike,
    out: PathLike | None = None,
    *,
    watcher: Watcher | None = None,
    **options: Unpack[RunOptions],
) -> AnyResults:
    """Run a study of any kind and write its results folder.

    Args:
        study: A study, a file, or the name of a shipped study.
        out: Results folder, which must not exist; by default results/NAME.
        watcher: Callbacks that hear of progress.
        **options: Options as of the command line.

    Returns:
        `TuningResults` or `ContestResults`, as the study is. A run for a firmware with a file of present
        gains, `controller.default`, ends with the opinion of `judge` against them, `results.opinion`.

    Raises:
        InputError: The study is wrong, or an option does not go with it.
        StoreError: The folder exists already, or cannot be written.

    Examples:
        >>> results = tuner.run(study, "results/second", threads=2)
        >>> results.feasible, len(results.history)
        (True, 3)

    """
    given = loaded(study)
    results = open_run(registry.run(given, None if out is None else Path(out), watcher, **options))
    results.study = given
    if isinstance(results, TuningResults):
        end_with_opinion(results, options.get("threads"), watcher or default_watcher())
    return results


@with_options(ResumeOptions, lambda _, hint, option: hint)
def resume(results: PathLike, *, watcher: Watcher | None = None, **options: Unpack[ResumeOptions]) -> AnyResults:
    """Go on with a run that was stopped; it ends with the bits that it would have ended with.

    Args:
        results: Its results folder.
        watcher: Callbacks that hear of progress.
        **options: Options as of the command line.

    Returns:
        The results, as `run` does.

    Raises:
        StoreError: The folder is missing or damaged, or another version wrote it.
        InputError: The budget or the flights are below what the run had, or an option does not go with its kind.

    Examples:
        >>> tuner.resume("results/first", budget=4).history.index.max()
        3

    """
    return open_run(resuming.resume(Path(results), watcher, **options))


def rejudge(
    results: PathLike,
    out: PathLike,
    *,
    study: PathLike | None = None,
    changes: Mapping[str, PlainValue] | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> TuningResults:
    """Re-evaluate recorded flights under other objectives, risks or limits.

    Args:
        results: Results folder of a tuning run.
        out: Results folder to write; must not exist.
        study: Study file to judge by; by default that of the run.
        changes: Values that replace those of the study, by dotted key.
        watcher: Callbacks that hear of progress.
        threads: Threads, by default one for each core.

    Returns:
        The results of the new judgement.

    Raises:
        InputError: The study asks for other flights than those of the run.
        StoreError: A folder is missing, not finished, or exists already.

    Examples:
        >>> judged = tuner.rejudge("results/first", "results/cvar90", changes={"objective.0.level": 0.9})
        >>> judged.summary.index[0]
        'cvar90(itae.position)'

    """
    by = None if study is None else study_file(Path(study))
    judging.rejudge(Path(results), Path(out), by, changes, watcher, threads=threads)
    return TuningResults(Path(out), TuningFolder(Path(out)).document)


def verify(
    results: PathLike,
    *,
    sample: int | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> verification.Verdict:
    """Fly a recorded run again and compare every bit.

    Args:
        results: A results folder.
        sample: Number of random candidates to re-simulate; default: all.
        watcher: Callbacks that hear of progress.
        threads: Threads, by default one for each core.

    Returns:
        The verdict: `identical`; `same`, where the last digits of margins do not count; and the first difference in `words`.

    Raises:
        StoreError: The folder is missing or damaged, or of another version.

    Examples:
        >>> tuner.verify("results/first", sample=2).identical
        True

    """
    return verification.verify(Path(results), sample, threads, watcher or default_watcher())


def open_run(done: registry.CompletedRun) -> AnyResults:
    """Return the results of a run that has just ended."""
    results = open_results(done.path)
    results.flights_made = getattr(done.outcome, "flights_made", None)
    return results
