"""A results folder: what a run writes, each file aside first and then renamed, so that a kill leaves no half file.

run.json, inputs/, study.toml, resolved.json, environment.json, history.csv, generations/NNNN.parquet, flights/, front.csv,
summary.json, gains.json, responses.parquet, report.html, figures/. The contents of each are told in results/README.md.
A file is on the disk before its name is, and its name before the next file is begun.
"""

import json
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from plant.errors import StoreError
from tuner.store.lock import Lock

ASIDE = ".aside"
"""Ending of the name under which a file is written before it gets its own."""


class Folder:
    """A results folder that this process, and no other, writes."""

    def __init__(self, path: Path, lock: Lock) -> None:
        self.path = path
        self._lock = lock

    @classmethod
    def create(cls, path: Path, inside: str = "generations") -> "Folder":
        """Make a new folder, with one inside; StoreError if anything is there already: nothing is ever overwritten."""
        if path.exists():
            raise StoreError(
                f"{path} exists already and nothing in it was touched; continue it with `tuner resume {path}`, choose another "
                f"folder with --out, or remove it"
            )
        try:
            (path / inside).mkdir(parents=True)
        except OSError as error:
            raise StoreError(f"{path} cannot be made ({_reason(error)}); choose another folder with --out") from error
        return cls(path, Lock(path))

    @classmethod
    def open(cls, path: Path) -> "Folder":
        """Open a folder to go on writing it; StoreError where there is none, or where another process writes it."""
        if not path.is_dir():
            raise StoreError(f"{path}: there is no such results folder; give a folder that `tuner run` wrote")
        folder = cls(path, Lock(path))
        folder._clear()
        return folder

    @classmethod
    def open_or_create(cls, path: Path) -> "Folder":
        """Open a folder, or make it where there is none."""
        return cls.open(path) if path.is_dir() else cls.create(path)

    def close(self) -> None:
        """Let other processes write it."""
        self._lock.release()

    def write_text(self, name: str, text: str) -> None:
        """Write a text file."""
        self.write_bytes(name, text.encode())

    def write_bytes(self, name: str, content: bytes) -> None:
        """Write a file of bytes."""
        self._aside(name, lambda file: file.write_bytes(content))

    def write_json(self, name: str, content: Any) -> None:
        """Write a JSON file; non-finite numbers are our own mistake."""
        self.write_text(name, json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False) + "\n")

    def write_table(self, name: str, table: Any) -> None:
        """Write a pandas table as .csv or .parquet, by the ending of the name."""
        if name.endswith(".csv"):
            self.write_text(name, csv_text(table))
        else:
            self._aside(name, lambda file: table.to_parquet(file, index=False))

    def _aside(self, name: str, write: Callable[[Path], Any]) -> None:
        file = self.path / name
        aside = file.with_name(f".{file.name}{ASIDE}")
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            write(aside)
            _settled(aside)
            aside.replace(file)
            _settled(file.parent)
        except OSError as error:
            with suppress(OSError):
                aside.unlink(missing_ok=True)
            raise StoreError(
                f"{file} cannot be written ({_reason(error)}); what was written before it is kept. Make room, then go on "
                f"with `tuner resume`"
            ) from error

    def _clear(self) -> None:
        """Remove what a killed process left half written."""
        for file in self.path.rglob(f".*{ASIDE}"):
            with suppress(OSError):
                file.unlink()


def csv_text(table: Any) -> str:
    """Return a pandas table as CSV; numbers with all their digits."""
    return table.to_csv(index=False, float_format="%.17g", lineterminator="\n")


def _reason(error: OSError) -> str:
    return error.strerror or str(error)


def _settled(path: Path) -> None:
    """Have the disk take what was written: a file's bytes, or a folder's names where the system can do that."""
    if path.is_dir() and os.name != "posix":
        return
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
