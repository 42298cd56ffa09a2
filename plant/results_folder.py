"""Recognition of results folders by the files that a run leaves; a stranger may have removed some of them."""

import os
from pathlib import Path

RECORDS = (
    "run.json",
    "manifest.json",
    "resolved.json",
    "environment.json",
    "summary.json",
    "comparison.json",
    "contest.json",
)
"""Files of which a results folder holds at least one."""
TABLES = ("*.npz", "*.parquet")
"""Files of recorded flights, the latter in folders of earlier versions."""


def results_folder_of(path: Path) -> Path | None:
    """Return the outermost results folder around a path, by its name, or None."""
    return next((folder for folder in reversed(path.absolute().parents) if is_results_folder(folder)), None)


def is_results_folder(folder: Path) -> bool:
    """Return True if a folder holds a run's record or flights."""
    return any(os.path.exists(folder / name) for name in RECORDS) or any(
        any((folder / "flights").glob(kind)) for kind in TABLES
    )


def in_results_folder(path: Path) -> bool:
    """Return True if a path lies in a results folder: however deep, by its name or behind its links."""
    return results_folder_of(path) is not None or results_folder_of(path.resolve()) is not None
