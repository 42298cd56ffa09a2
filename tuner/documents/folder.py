"""A results folder, opened: its typed document at once, its other documents and its tables when they are asked for."""

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Generic, TypeVar

from plant.errors import StoreError
from tuner.documents.tables import read_frame
from tuner.store.document import Document, read_text
from tuner.store.environment import Environment

if TYPE_CHECKING:
    import pandas as pd

D = TypeVar("D", bound=Document)


class OpenedFolder(Generic[D]):
    """A results folder.

    Attributes:
        kind: Name of the kind of results.
        noun: The kind in a sentence, with its article.
        main: Name of the file with the main document.
        folder: Where it is.
        document: Content of the main document.

    """

    kind: ClassVar[str]
    noun: ClassVar[str]
    main: ClassVar[str]
    model: ClassVar[type[Document]]

    def __init__(self, folder: Path) -> None:
        if not folder.is_dir():
            raise StoreError(f"{folder}: there is no such results folder; give a folder that `tuner run` wrote")
        self.folder = folder
        self.document: D = self.model.read(folder / self.main)  # pyright: ignore[reportAttributeAccessIssue]

    @cached_property
    def environment(self) -> Environment:
        """Versions, machine and command; StoreError where the folder does not tell them."""
        return Environment.read(self.folder / "environment.json")

    @cached_property
    def study(self) -> str:
        """The study as it was given; StoreError where the folder does not hold it."""
        return read_text(self.folder / "study.toml")

    @property
    def tables(self) -> list[str]:
        """Names of the tables of the folder, for `table`."""
        return sorted(file.name for pattern in ("*.csv", "*.parquet") for file in self.folder.glob(pattern))

    def table(self, name: str) -> "pd.DataFrame":
        """Return a table of the folder as it stands, by the name of its file; StoreError where it is missing or damaged."""
        return read_frame(self.folder / name)
