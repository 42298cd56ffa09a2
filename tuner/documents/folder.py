"""A results folder, opened: its typed document at once, its other documents and its tables when they are asked for."""

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Generic, TypeVar, cast

from plant.errors import StoreError
from tuner.documents.tables import read_frame
from tuner.store.document import Document, read_text
from tuner.store.environment import Environment
from tuner.store.tables import table_files

if TYPE_CHECKING:
    import pandas as pd

D = TypeVar("D", bound=Document)


class OpenedFolder(Generic[D]):
    """A results folder.

    Attributes:
        kind: Name of the kind of results.
        noun: The kind in a sentence, with its article.
        main: Name of the file with the main document.
        folder: Path of the folder; None if its document is all there is.
        document: Content of the main document, in SI units and radians.
    """

    kind: ClassVar[str]
    noun: ClassVar[str]
    main: ClassVar[str]
    model: ClassVar[type[Document]]

    def __init__(self, folder: Path | None, document: D | None = None) -> None:
        self.folder = folder
        # Every kind names the model of its own document.
        self.document = cast("D", self.model.read(existing(self.home) / self.main)) if document is None else document

    @property
    def home(self) -> Path:
        """The results folder; StoreError where there is none."""
        if self.folder is None:
            raise StoreError("these results were not written to a folder; give one with out")
        return self.folder

    @cached_property
    def environment(self) -> Environment:
        """Versions, machine and command; StoreError where the folder does not tell them."""
        return Environment.read(self.home / "environment.json")

    @cached_property
    def study_text(self) -> str:
        """The study as it was given; StoreError where the folder does not hold it."""
        return read_text(self.home / "study.toml")

    @property
    def tables(self) -> list[str]:
        """Names of the tables of the folder, for `table`."""
        return sorted(file.name for file in [*self.home.glob("*.csv"), *table_files(self.home)])

    def table(self, name: str) -> "pd.DataFrame":
        """Return a table of the folder as it stands, by the name of its file; StoreError where it is missing or damaged."""
        return read_frame(self.home / name)


def existing(folder: Path) -> Path:
    """Return a results folder; StoreError where there is none."""
    if not folder.is_dir():
        raise StoreError(f"{folder}: there is no such results folder; give a folder that `tuner run` wrote")
    return folder
