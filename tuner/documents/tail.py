"""tail.json: probabilities of events of a flight, in SI units."""

from typing import Annotated, Literal

from tuner.documents.parts import SampledValue
from tuner.store.document import Document, DocumentPart
from tuner.text.product import READ_FORMER

TAIL_FORMAT, TAIL_VERSION = "gainproof-tail", "0.1"


class TailPoint(DocumentPart):
    """The most likely flight that fails by a mode. name: by which `tuner fly --flight` flies it.

    distance: from the flight without deviations, in standard deviations; shares: of the squared distance, by the part drawn;
    numbers: deviations of single numbers of the parts that have names, such as "vehicle mass".
    """

    name: str
    distance: float
    shares: dict[str, float]
    numbers: dict[str, float]


class TailMode(DocumentPart):
    """One way in which an event happens. probability: that it happens so; share: of the event's probability."""

    mode: str
    probability: SampledValue
    share: SampledValue
    point: TailPoint | None


class TailLevel(DocumentPart):
    """Probability that the metric, or of a loss the largest demand over capacity, reaches a level, with its 95 % interval."""

    level: float
    probability: float
    low: float
    high: float


class TailEvent(DocumentPart):
    """An event. limit: of its metric in its unit, 1 of a loss. low, high: of the 95 % interval of its probability.

    status: "estimated"; "wide" where the flights allowed were too few for the width; "below" the smallest probability, where
    `high` bounds it; "unreached" where no flight came nearer; "certain"; "deterministic" where nothing is drawn.
    """

    event: str
    metric: str | None
    unit: str
    limit: float
    status: str
    method: str
    probability: float
    low: float
    high: float
    flights: int
    replicas: int
    modes: list[TailMode]
    curve: list[TailLevel]


class TailGains(DocumentPart):
    """Gains and the probabilities of all events under them."""

    gains: str
    laws: str
    events: list[TailEvent]


class TailRatio(DocumentPart):
    """Probability of an event under gains over that under the first, with its 95 % interval; null where one is not known."""

    event: str
    gains: str
    first: str
    ratio: SampledValue | None


class TailDocument(Document):
    """Content of tail.json.

    smallest: probability down to which was looked; width: of the interval, over the probability; parts: number of normals that
    each part of a flight is drawn from.
    """

    format: Annotated[Literal["gainproof-tail"], READ_FORMER]
    version: Literal["0.1"]
    scenario: str
    duration: float
    seed: int
    smallest: float
    width: float
    most_flights: int
    parts: dict[str, int]
    gains: list[TailGains]
    ratios: list[TailRatio]
