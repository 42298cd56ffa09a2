"""tail.json: probabilities of events of a flight, in SI units."""

from typing import Annotated, Literal

from tuner.documents.parts import SampledValue
from tuner.documents.tail import TailEvent
from tuner.store.document import Document, DocumentPart
from tuner.text.product import READ_FORMER

TAIL_FORMAT, TAIL_VERSION = "gainproof-tail", "0.1"


class TailGains(DocumentPart):
    """Gains and the probabilities of all events under them."""

    gains: str
    laws: str
    events: list[TailEvent]


class TailRatio(DocumentPart):
    """Probability of an event under gains over that under the first.

    It has a 95 % interval, and is null where one of the two is not known.
    """

    event: str
    gains: str
    first: str
    ratio: SampledValue | None


class TailDocument(Document):
    """Content of tail.json.

    Args:
        format: Format of the file.
        version: Version of the format.
        scenario: Name.
        duration: Duration of a flight [s].
        seed: Root seed.
        smallest: Probability down to which was looked.
        width: Width of the interval, over the probability.
        most_flights: Number of flights of an event at most.
        worst: Part of a flight whose design point alone was sought, null for all.
        parts: Number of normals that each part of a flight is drawn from.
        gains: Probabilities by gains.
        ratios: Ratios of others to the first.
    """

    format: Annotated[Literal["gainproof-tail"], READ_FORMER]
    version: Literal["0.1"]
    scenario: str
    duration: float
    seed: int
    smallest: float
    width: float
    most_flights: int
    worst: str | None = None
    parts: dict[str, int]
    gains: list[TailGains]
    ratios: list[TailRatio]
