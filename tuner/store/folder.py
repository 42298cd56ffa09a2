"""A results folder: what a run writes, each file aside first and then renamed, so that a kill leaves no half file.

study.toml, resolved.json, environment.json, history.csv, generations/NNNN.parquet, front.csv, summary.json, gains.json,
responses.parquet, report.html, figures/. The contents of each are told in results/README.md.
"""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from plant.errors import StoreError


class Folder:
    """A results folder that this process writes."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def create(cls, path: Path, inside: str = "generations") -> "Folder":
        """Make a new folder, with one inside; StoreError if anything is there already: nothing is ever overwritten."""
        if path.exists():
            raise StoreError(
                f"{path} exists already and nothing in it was touched; choose another folder with --out, or remove it"
            )
        try:
            (path / inside).mkdir(parents=True)
        except OSError as error:
            raise StoreError(f"{path} cannot be made ({error.strerror}); choose another folder with --out") from error
        return cls(path)

    def write_text(self, name: str, text: str) -> None:
        """Write a text file."""
        self._aside(name, lambda file: file.write_text(text, encoding="utf-8"))

    def write_json(self, name: str, content: Any) -> None:
        """Write a JSON file; non-finite numbers are our own mistake."""
        self.write_text(name, json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False) + "\n")

    def write_table(self, name: str, table: Any) -> None:
        """Write a pandas table as .csv or .parquet, by the ending of the name."""
        if name.endswith(".csv"):
            self._aside(name, lambda file: table.to_csv(file, index=False, float_format="%.17g"))
        else:
            self._aside(name, lambda file: table.to_parquet(file, index=False))

    def _aside(self, name: str, write: Callable[[Path], Any]) -> None:
        file = self.path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        aside = file.with_name(f".{file.name}.{os.getpid()}")
        try:
            write(aside)
            aside.replace(file)
        except OSError as error:
            aside.unlink(missing_ok=True)
            raise StoreError(
                f"{file} cannot be written ({error.strerror}); what was written before it is kept"
            ) from error
