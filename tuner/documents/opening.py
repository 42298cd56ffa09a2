"""Open a results folder of any kind: the one door to what a run leaves."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from plant.errors import InputError, StoreError
from tuner.documents.comparison import ComparisonFolder
from tuner.documents.export import ExportDocument
from tuner.documents.folder import OpenedFolder, existing
from tuner.documents.margins import MarginsDocument
from tuner.documents.tuning import TuningFolder
from tuner.extension import BUNDLED_NAMES, extensions, load, refuse_lacking
from tuner.store.advice import kind_of


class MarginsFolder(OpenedFolder[MarginsDocument]):
    """Margins of a controller with their figures."""

    kind, noun, main, model = "margins", "a report on margins", "margins.json", MarginsDocument


class ExportFolder(OpenedFolder[ExportDocument]):
    """Files for a target."""

    kind, noun, main, model = "export", "an export", "export.json", ExportDocument


# A folder is of the first kind whose document it holds: a run may hold its sensitivity.
KINDS: tuple[type[OpenedFolder[Any]], ...] = (
    ComparisonFolder,
    TuningFolder,
    MarginsFolder,
    ExportFolder,
    *[load(reference) for entry in extensions().values() for reference in entry.folders],
)
"""Every kind of results folder."""


def kind_in(folder: Path, kinds: Sequence[type[OpenedFolder[Any]]] = KINDS) -> type[OpenedFolder[Any]] | None:
    """Return the kind of a results folder; None where it holds the document of none, such as that of a run in progress."""
    return next((kind for kind in kinds if (folder / kind.main).exists()), None)


def open_results(folder: Path, kinds: Sequence[type[OpenedFolder[Any]]] = KINDS) -> Any:
    """Open a results folder of one of some kinds; StoreError where it is none, or its document is damaged."""
    kind = kind_in(existing(folder), kinds)
    if kind is None:
        refuse_lacking("experiments", kind_of(folder) or "", file=folder)
        for name in BUNDLED_NAMES["documents"]:
            if (folder / f"{name}.json").exists():
                refuse_lacking("documents", name, file=folder)
        names = ", ".join(entry.main for entry in kinds)
        raise StoreError(f"{folder} is no finished results folder: it holds none of {names}")
    return kind(folder)


def gains_file(path: Path) -> Path:
    """Return the gains.json in a tuning run's folder, or a file itself."""
    if not path.is_dir():
        return path
    if kind_in(path) is not TuningFolder:
        raise InputError(
            "is a folder, but that of no finished tuning run; give one of these, or a gains.json", file=path
        )
    return path / TuningFolder(path).document.gains_file
