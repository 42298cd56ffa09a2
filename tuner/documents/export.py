"""export.json: what was written for a target, and what rounding to its resolution does."""

from typing import Annotated, Literal

from pydantic import Field

from tuner.documents.parts import LawNames
from tuner.store.document import Document, DocumentPart, Sense
from tuner.text.product import READ_FORMER

EXPORT_FORMAT, EXPORT_VERSION = "gainproof-export", "1.0"


class ExportedParameter(DocumentPart):
    """A number as the target holds it, in its own unit; a bound that is none is null.

    asked: before rounding; held: after it; usual: the target's default; before: on the vehicle, null if unknown; kept: our
    loops have no such thing, so the vehicle's value stays; change: held minus before.
    """

    name: str
    unit: str
    unrounded: float = Field(alias="asked")
    held: float
    low: float | None
    high: float | None
    usual: float | None
    before: float | None
    is_unmanaged: bool = Field(alias="kept")
    change: float | None


class RoundedGain(DocumentPart):
    """A gain before and after rounding; relative: change relative to what was asked, or to 1 where that is 0."""

    gain: str
    unit: str
    unrounded: float = Field(alias="asked")
    held: float
    relative: float


class RoundedMargin(DocumentPart):
    """A limit on a margin before and after rounding; infinite values are null.

    state: steady state in which it is worst after rounding, null where hover alone was looked at.
    """

    label: str
    quantity: str | None
    unit: str
    shown_unit: str | None = None
    limit: float
    sense: Sense
    unrounded: float | None = Field(alias="asked")
    held: float | None
    kept_asked: bool
    kept_held: bool
    state: str | None = None


class RoundedMetric(DocumentPart):
    """Mean of a metric over the same flights before and after rounding; difference: flight by flight with its 95 % interval.

    Flights that one of the two loses are left out, but of `failure`; null where every flight is lost.
    """

    metric: str
    unit: str
    unrounded: float | None = Field(alias="asked")
    held: float | None
    difference: float | None
    low: float | None
    high: float | None


class FilteredLoop(DocumentPart):
    """Phase margin of a loop with our derivative filter and with the target's low-pass; spare: ours over the limit."""

    loop: str
    unit: str
    limit: float
    ours: float
    theirs: float
    taken: float
    spare: float
    breaks: bool


class GyroFilterPart(DocumentPart):
    """Low-pass of the target between the gyro and its loops; cutoff [Hz]; known: it is from the vehicle's file."""

    name: str
    cutoff: float
    is_from_vehicle_file: bool = Field(alias="known")
    rows: list[FilteredLoop]


class VerificationPart(DocumentPart):
    """Gains, margins and flights before and after rounding; broken: limits that hold before and not after it.

    lost_asked, lost_held: flights lost before and after rounding; null in files of version 0.2.0 and before.
    """

    passed: bool
    broken: list[str]
    scenario: str
    stream: str
    seed: int
    flights: int
    lost_asked: int | None = None
    lost_held: int | None = None
    gains: list[RoundedGain]
    margins: list[RoundedMargin]
    metrics: list[RoundedMetric]
    gyro_filter: GyroFilterPart | None


class ExportDocument(Document):
    """Content of export.json.

    files: SHA-256 by name; rollback: files to go back to; settings: options of the target; before: where it is known from what is
    on the vehicle, null if unknown; lossy: what the target adds or lacks. Of a quadrotor there are airframe and laws, of a
    plant plant and channel_laws.
    """

    format: Annotated[Literal["gainproof-export"], READ_FORMER]
    version: Literal["1.0"]
    generator: str
    target: str
    target_version: str
    title: str
    experimental: str | None
    airframe: str | None = None
    laws: LawNames | None = None
    plant: str | None = None
    channel_laws: dict[str, str] | None = None
    gains_sha256: str
    files: dict[str, str]
    rollback: list[str]
    settings: dict[str, str]
    before: str | None
    lossy: list[str]
    parameters: list[ExportedParameter]
    verification: VerificationPart
