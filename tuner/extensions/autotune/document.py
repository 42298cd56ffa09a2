"""autotune.json: the way from logs and a vehicle's parameters to tuned ones, stage by stage."""

from typing import Annotated, Literal

from tuner.store.document import Document, DocumentPart, OneOf

AUTOTUNE_FORMAT, AUTOTUNE_VERSION = "gainproof-autotune", "0.1"
DONE, STOPPED = "done", "stopped"


class StageRow(DocumentPart):
    """A stage of an autotune.

    Args:
        stage: Name.
        state: Done or stopped.
        sentence: Result.
        folder: File or folder of the result.
        seconds: Time that it took, 0 where it was on record.
    """

    stage: str
    state: Annotated[str, OneOf((DONE, STOPPED))]
    sentence: str
    folder: str
    seconds: float


class AutotuneDocument(Document):
    """Content of autotune.json.

    Args:
        source: Firmware of the parameter file.
        airframe: Prior, as given.
        logs: Files, as given.
        vehicle: Parameter file, as given.
        stages: Up to the one that ends the way.
        is_complete: Whether all stages are done; the way ends where the opinion objects.
        sentence: Result.
        commands: Next commands.
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
