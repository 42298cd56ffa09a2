"""approach.json: the way from the gains that a vehicle flies to tuned ones in steps, in SI units: gain margins as factors."""

from typing import Annotated, Literal

from tuner.documents.margins import ChannelMargins, LimitRow
from tuner.documents.parts import LawNames
from tuner.store.document import Document, DocumentPart
from tuner.text.product import READ_FORMER

APPROACH_FORMAT, APPROACH_VERSION = "gainproof-approach", "0.1"


class Expected(DocumentPart):
    """A measurement of the completed flights of a step: median and the quantiles that hold 90 % of them, null for none."""

    metric: str
    unit: str
    median: float | None
    low: float | None
    high: float | None


class StepOfApproach(DocumentPart):
    """Gains on the way and what is known of them. share: 0 for what flies now, 1 for the tuned ones; gains: by address;
    factor: by which the gain that moves most has changed since the step before; gain: that gain. short: margins that are worse
    than allowed; expected: what its flights measure; lost: flights lost, null in files of version 0.2.0 and before.
    """

    share: float
    gains: dict[str, float]
    gain: str | None
    factor: float
    stable: bool
    channels: list[ChannelMargins]
    short: list[LimitRow]
    expected: list[Expected]
    lost: int | None = None


class ApproachDocument(Document):
    """Content of approach.json; passed: every step is stable, no margin falls short and no flight is lost; notes: what differs
    besides gains.
    """

    format: Annotated[Literal["gainproof-approach"], READ_FORMER]
    version: Literal["0.1"]
    airframe: str
    laws: LawNames
    scenario: str
    flights: int
    steps: list[StepOfApproach]
    notes: list[str]
    passed: bool
