"""Results and gains on the same flights."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import cast

from tuner.api.gains import Gains, default_of
from tuner.api.results import ComparisonResults, Results
from tuner.api.studies import StudyLike, gains_study, refuse_codeless
from tuner.experiments.compare import run as comparing
from tuner.experiments.compare.entrants import Entrant, read_entrants
from tuner.search.watcher import Watcher
from tuner.study.files import named_study


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
        entrants: Two or more results folders, gains files, studies for their default, or gains and results in memory.
        out: New folder for numbers, figures and a page.
        study: Study whose scenarios are flown; by default that of the first results folder or study.
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
    studies = [*([] if study is None else [study]), *filter(None, map(_study_of, entrants))]
    given = gains_study(studies[0], "tuner compare --study") if studies else None
    folder = None if out is None else Path(out)
    return ComparisonResults(folder, comparing.compare(_read(entrants), given, flights, folder, watcher, threads))


def _study_of(entrant: str | Path | Results | Gains) -> StudyLike | None:
    """Return the study of an entrant that is no results folder."""
    return named_study(Path(entrant)) if isinstance(entrant, str | Path) else getattr(entrant, "study", None)


def _read(entrants: Sequence[str | Path | Results | Gains]) -> list[Entrant]:
    """Return entrants; gains in no file have the name of their study, or of their place."""
    names, paths = dict[Path, str](), list[Path]()
    with ExitStack() as stack:
        for place, entrant in enumerate(entrants, 1):
            path = path_of(entrant)
            if path is None or named_study(path) is not None:
                gains = entrant if isinstance(entrant, Gains) else default_of(cast(Path, path))
                name = f"gains-{place}" if path is None else str(path)
                path = stack.enter_context(gains.file())
                names[path] = name
            refuse_codeless(path)
            paths.append(path)
        read = read_entrants(paths)
    short = [Path(names[each.source]).stem if each.source in names else each.name for each in read]
    return [_named(each, name, short.count(name) > 1, names) for each, name in zip(read, short, strict=True)]


def _named(entrant: Entrant, short: str, is_shared: bool, names: Mapping[Path, str]) -> Entrant:
    """Return an entrant with its short name, or its path among namesakes.

    names: of studies and of gains in memory, by the file that they were read from.
    """
    source = names.get(entrant.source, str(entrant.source))
    return replace(entrant, name=source if is_shared else short, source=Path(source))


def path_of(entrant: str | Path | Results | Gains) -> Path | None:
    """Return the path of an entrant, None for gains in memory."""
    if isinstance(entrant, str | Path):
        return Path(entrant)
    return entrant.home if isinstance(entrant, Results) else entrant.path
