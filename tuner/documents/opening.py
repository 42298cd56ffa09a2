"""Open a results folder of any kind: its typed document at once, its tables as pandas when asked for."""

from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from plant.errors import StoreError
from plant.input_files import MOST_TABLE, read_input
from tuner.documents.contest_document import ComparisonDocument, ContestDocument
from tuner.documents.export import ExportDocument
from tuner.documents.inference_document import InferenceDocument
from tuner.documents.margins import MarginsDocument
from tuner.documents.sensitivity import SensitivityDocument
from tuner.documents.summary import Summary
from tuner.store.document import Document, read_text, refuse
from tuner.store.environment import Environment

if TYPE_CHECKING:
    import pandas as pd

    from tuner.documents.contest import ShownContest
    from tuner.documents.inference import ShownInference
    from tuner.documents.results import Results

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


class TuningFolder(OpenedFolder[Summary]):
    """Results of a tuning run."""

    kind, noun, main, model = "tuning", "a tuning run", "summary.json", Summary

    @cached_property
    def results(self) -> "Results":
        """Documents and tables together, as a report shows them."""
        from tuner.documents.loading import load

        return load(self.folder)


class ContestFolder(OpenedFolder[ContestDocument]):
    """Results of a contest."""

    kind, noun, main, model = "contest", "a contest", "contest.json", ContestDocument

    @cached_property
    def results(self) -> "ShownContest":
        """Documents and tables together, as a report shows them."""
        from tuner.documents.contest_loading import load_contest

        return load_contest(self.folder)


class ComparisonFolder(OpenedFolder[ComparisonDocument]):
    """Results of a comparison."""

    kind, noun, main, model = "comparison", "a comparison", "comparison.json", ComparisonDocument

    @cached_property
    def results(self) -> "ShownContest":
        """Documents and tables together, as a report shows them."""
        from tuner.documents.contest_loading import load_contest

        return load_contest(self.folder)


class InferenceFolder(OpenedFolder[InferenceDocument]):
    """Results of an inference."""

    kind, noun, main, model = "inference", "an inference", "inference.json", InferenceDocument

    @cached_property
    def results(self) -> "ShownInference":
        """The document as a report shows it."""
        from tuner.documents.inference import load_inference

        return load_inference(self.folder / self.main)


class SensitivityFolder(OpenedFolder[SensitivityDocument]):
    """Results of a sensitivity analysis."""

    kind, noun, main, model = "sensitivity", "a sensitivity analysis", "sensitivity.json", SensitivityDocument


class MarginsFolder(OpenedFolder[MarginsDocument]):
    """Margins of a controller with their figures."""

    kind, noun, main, model = "margins", "a report on margins", "margins.json", MarginsDocument


class ExportFolder(OpenedFolder[ExportDocument]):
    """Files for a target."""

    kind, noun, main, model = "export", "an export", "export.json", ExportDocument


# A folder is of the first kind whose document it holds: a contest may hold its inference, a run its sensitivity.
KINDS: tuple[type[OpenedFolder[Any]], ...] = (
    ComparisonFolder, ContestFolder, InferenceFolder, TuningFolder, SensitivityFolder, MarginsFolder, ExportFolder,
)  # fmt: skip
"""Every kind of results folder."""


def kind_in(folder: Path) -> type[OpenedFolder[Any]] | None:
    """Return the kind of a results folder; None where it holds the document of none, such as that of a run in progress."""
    return next((kind for kind in KINDS if (folder / kind.main).exists()), None)


def open_results(folder: Path) -> OpenedFolder[Any]:
    """Open a results folder of any kind; StoreError where it is none, or its document is damaged."""
    if not folder.is_dir():
        raise StoreError(f"{folder}: there is no such results folder; give a folder that `tuner run` wrote")
    kind = kind_in(folder)
    if kind is None:
        names = ", ".join(entry.main for entry in KINDS)
        raise StoreError(f"{folder} is no finished results folder: it holds none of {names}")
    return kind(folder)


def read_frame(file: Path) -> "pd.DataFrame":
    """Return a CSV or Parquet table as it stands; StoreError where it is missing or damaged."""
    import pandas as pd

    try:
        if file.suffix == ".csv":
            return pd.read_csv(BytesIO(read_input(file, MOST_TABLE)))
        return pd.read_parquet(BytesIO(read_input(file, MOST_TABLE)))
    except FileNotFoundError:
        raise refuse(file, "there is no such file") from None
    except (OSError, ValueError) as error:
        raise refuse(file, f"not a readable table ({str(error).splitlines()[0]:.80})") from None
