"""confirm.json: finalists flown in a real firmware, next to our own flights through the same scenarios, in SI units."""

from typing import Annotated, Literal

from tuner.documents.parts import Estimate
from tuner.store.document import Document, DocumentPart
from tuner.text.product import READ_FORMER

CONFIRMATION_FORMAT, CONFIRMATION_VERSION = "gainproof-confirmation", "0.1"


class ConfirmedValue(DocumentPart):
    """A quantity of one finalist. firmware, model: its risk over the flights of each; gap: firmware minus model, paired."""

    firmware: float
    model: float
    gap: Estimate


class ConfirmedPoint(DocumentPart):
    """A finalist. lost_firmware, lost_model: flights that did not reach their end; values: in the order of the quantities."""

    point: str
    lost_firmware: int
    lost_model: int
    values: list[ConfirmedValue]


class ConfirmedQuantity(DocumentPart):
    """A metric under a risk. correlation: of the finalists' ranks between firmware and model (Spearman), null where ranks are
    all the same or finalists fewer than three; gap: mean of all finalists, firmware minus model; relative: that over the mean of
    the model, null where it is 0; jitter: largest difference of a flight flown twice in the firmware, null where none was.
    """

    label: str
    metric: str
    definition: str
    unit: str
    scenario: str | None
    correlation: Estimate
    gap: Estimate
    relative: float | None
    jitter: float | None


class ConfirmationDocument(Document):
    """Content of confirm.json. flights: of each scenario and finalist; program: SHA-256 of the firmware's program; lockstep:
    whether it runs in step with the plant; notes: what is rounded, and what the export says it adds or lacks; seconds: of the
    flights in the firmware.
    """

    format: Annotated[Literal["gainproof-confirmation"], READ_FORMER]
    version: Literal["0.1"]
    title: str
    firmware: str
    target_version: str
    program: str
    lockstep: bool
    seed: int
    stream: str
    flights: int
    quantities: list[ConfirmedQuantity]
    points: list[ConfirmedPoint]
    notes: list[str]
    seconds: float
