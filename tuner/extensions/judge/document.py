"""The document of a read-back: what a vehicle holds after writing, in SI units."""

from typing import Literal

from tuner.documents.assessment import AssessedFile, ParameterChange
from tuner.store.document import Document


class ReadBackDocument(Document):
    """Parameters on a vehicle against the file that was written to it. compared: their number."""

    format: Literal["gainproof-read-back"]
    version: Literal["0.1"]
    written: AssessedFile
    dump: AssessedFile
    compared: int
    differing: list[ParameterChange]
    sentence: str
