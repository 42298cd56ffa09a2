"""The opinion that ends a run for a firmware: the tuned gains against those that the vehicle flies at present."""

from pathlib import Path
from typing import TYPE_CHECKING

from plant.errors import InputError
from tuner.api.results import AnyResults, TuningResults
from tuner.documents.summary import GAINS
from tuner.documents.tuning import DEFAULT
from tuner.report import write_report
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder

if TYPE_CHECKING:
    from tuner.api.judging import Assessment


def judge_against_present(results: AnyResults, threads: int | None, watcher: Watcher) -> "Assessment | None":
    """Return the opinion of `tuner judge` on a run's gains; None without present ones."""
    present = present_gains(results)
    if present is None:
        return None
    # Judging imports every target; a run without a firmware's file leaves them out.
    from tuner.api.judging import judge

    try:
        return judge(results.home / GAINS, present, threads=threads, watcher=watcher)
    except InputError as error:
        # The run is complete; only its comparison is missing.
        watcher.on_message(f"Not judged against the present gains: {error}")
        return None


def add_opinion(results: TuningResults, opinion: "Assessment") -> None:
    """Add an opinion to the summary and report of a completed run."""
    results.opinion = opinion
    results.document = results.document.model_copy(update={"opinion": opinion.document})
    with Folder.open(results.home) as folder:
        folder.write_json(results.main, results.document)
        write_report(folder.path, results)
        folder.amend("report.html")


def present_gains(results: AnyResults) -> Path | None:
    """Return the file of present gains; None where nothing new is recommended."""
    if not isinstance(results, TuningResults) or not results.feasible or results.document.tuned == DEFAULT:
        return None
    return getattr(results.study, "present_gains", None)
