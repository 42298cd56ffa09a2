"""Results and gains on the same flights."""

from collections.abc import Sequence
from pathlib import Path

from plant.errors import InputError
from tuner.api.gains import Gains
from tuner.api.results import ComparisonResults, Results
from tuner.api.studies import StudyLike, gains_study, refuse_codeless
from tuner.experiments.compare import run as comparing
from tuner.search.watcher import Watcher


def compare(
    entrants: Sequence[str | Path | Results | Gains],
    out: str | Path | None = None,
    *,
    study: StudyLike | None = None,
    flights: int | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> ComparisonResults:
    """Compare results and gains with the first, flight by flight.

    All fly through the same scenarios.

    Args:
        entrants: Two or more results folders, gains files, or what was opened or read from them.
        out: New folder for numbers, figures and a page.
        study: Study whose scenarios are flown; by default that of the first results folder.
        flights: Flights of each scenario; by default the study's held_out.
        watcher: Callbacks that hear of progress.
        threads: Threads, by default one for each core.

    Returns:
        Values and paired differences with 95 % intervals.

    Raises:
        InputError: An entrant cannot fly these scenarios, or there is no study.
        StoreError: The folder exists already, or a results folder is not finished.

    Examples:
        >>> compared = tuner.compare(["results/first", "mine.json"], flights=8)
        >>> compared.document.first
        'first'

    """
    given = None if study is None else gains_study(study, "tuner compare --study")
    folder = None if out is None else Path(out)
    paths = [path_of(entrant) for entrant in entrants]
    for path in paths:
        refuse_codeless(path)
    return ComparisonResults(folder, comparing.compare(paths, given, flights, folder, watcher, threads))


def path_of(entrant: str | Path | Results | Gains) -> Path:
    """Return the path of an entrant; InputError where it stands in no file."""
    if isinstance(entrant, str | Path):
        return Path(entrant)
    path = entrant.home if isinstance(entrant, Results) else entrant.path
    if path is None:
        raise InputError("these gains are in no file; write them first: gains.write('name.json')")
    return path
