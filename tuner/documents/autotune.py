"""autotune.json: the way from logs and a vehicle's parameters to tuned ones, stage by stage."""

from typing import Annotated, Literal

from tuner.store.document import Document, DocumentPart, OneOf

AUTOTUNE_FORMAT, AUTOTUNE_VERSION = "gainproof-autotune", "0.1"
DONE, STOPPED = "done", "stopped"


class StageRow(DocumentPart):
    """A stage. sentence: its result; folder: of its files; seconds: 0 where it was on record."""

    stage: str
    state: Annotated[str, OneOf((DONE, STOPPED))]
    sentence: str
    folder: str
    seconds: float


class AutotuneDocument(Document):
    """Content of autotune.json.

    source: firmware of the parameter file; airframe: the prior, as given; logs, vehicle: files as given; sentence: the end in one
    sentence; commands: what to type next.
    """

    format: Literal["gainproof-autotune"]
    version: Literal["0.1"]
    source: str
    airframe: str
    logs: list[str]
    vehicle: str
    stages: list[StageRow]
    is_complete: bool
    sentence: str
    commands: list[str]
