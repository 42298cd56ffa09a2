"""The opinion that ends a run: its gains against present ones, by an extension that judges."""

from pathlib import Path

from tuner.api.results import Opinion, TuningResults
from tuner.documents.tuning import DEFAULT
from tuner.extension import added, load
from tuner.report import write_report
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder


def end_with_opinion(results: TuningResults, threads: int | None, watcher: Watcher) -> None:
    """Judge the gains of a completed run against present ones.

    Nothing happens without both, or without an extension that judges.
    """
    present = present_gains(results)
    if present is None:
        return
    # Judging imports every target; a run without a firmware's file leaves them out.
    for reference in added("opinions").values():
        opinion: Opinion | None = load(reference)(results, present, threads, watcher)
        if opinion is not None:
            add_opinion(results, opinion)


def add_opinion(results: TuningResults, opinion: Opinion) -> None:
    """Add an opinion to the summary and report of a completed run."""
    results.opinion = opinion
    results.document = results.document.model_copy(update={"opinion": opinion.document})
    with Folder.open(results.home) as folder:
        folder.write_json(results.main, results.document)
        write_report(folder.path, results)
        folder.amend("report.html")


def present_gains(results: TuningResults) -> Path | None:
    """Return the file of present gains; None where nothing new is recommended."""
    if not results.feasible or results.document.tuned == DEFAULT:
        return None
    return getattr(results.study, "present_gains", None)
