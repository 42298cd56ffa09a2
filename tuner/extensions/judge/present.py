"""The opinion that ends a run for a firmware: the tuned gains against those that the vehicle flies at present."""

from pathlib import Path

from plant.errors import InputError
from tuner.api.results import TuningResults
from tuner.documents.summary import GAINS
from tuner.extensions.judge.api import Assessment, judge
from tuner.search.watcher import Watcher


def judge_against_present(
    results: TuningResults, present: Path, threads: int | None, watcher: Watcher
) -> Assessment | None:
    """Return the opinion of `tuner judge` on a run's gains; None where it cannot be formed.

    present: file of the present gains.
    """
    try:
        return judge(results.home / GAINS, present, threads=threads, watcher=watcher)
    except InputError as error:
        # The run is complete; only its comparison is missing.
        watcher.on_message(f"Not judged against the present gains: {error}")
        return None
