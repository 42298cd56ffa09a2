"""Estimates of a flight's events as parts of documents (SI)."""

from tuner.documents.parts import SampledValue, ShareCount
from tuner.store.document import DocumentPart


class TailPoint(DocumentPart):
    """The most likely flight that fails by a mode.

    Args:
        name: Name by which `tuner fly --flight` flies it.
        distance: From the flight without deviations, in standard deviations.
        shares: Shares of the squared distance, by the part drawn.
        numbers: Deviations of single numbers of the parts that have names, such as "vehicle mass".
    """

    name: str
    distance: float
    shares: dict[str, float]
    numbers: dict[str, float]


class TailMode(DocumentPart):
    """One way in which an event happens; share: of the event's probability."""

    mode: str
    probability: SampledValue
    share: SampledValue
    point: TailPoint | None


class TailLevel(DocumentPart):
    """Probability of reaching a level, with its 95 % interval.

    The level is one of the metric, or of a loss of the largest demand over capacity.
    """

    level: float
    probability: float
    low: float
    high: float


class TailEvent(DocumentPart):
    """An event and its probability.

    Args:
        event: Event as it was written.
        metric: Metric whose exceedance it is, null for a loss.
        unit: Unit of the metric.
        limit: Limit of the metric in its unit, 1 of a loss.
        status: "estimated"; "wide" where the flights allowed were too few for the width; "below" the smallest probability, where
            `high` bounds it; "unreached" where no flight came nearer; "certain"; "deterministic" where nothing is drawn.
        method: Method by which it was estimated.
        probability: Probability of the event.
        low: Lower end of its 95 % interval.
        high: Upper end of that.
        flights: Made for it, with those of the pilot and without those of design points.
        count: Number of independent flights, null where others were made.
        replicas: Independent estimates whose mean it is, or batches of flights.
        modes: Ways in which it happens.
        curve: On the way to the limit.
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
    count: ShareCount | None
    replicas: int
    modes: list[TailMode]
    curve: list[TailLevel]


class LimitedTail(DocumentPart):
    """The tail of a limited event in one scenario.

    Args:
        scenario: Name.
        confidence: Confidence of the intervals.
        smallest: Probability down to which was looked.
        width: Width of the interval of `tuned`, over the probability.
        tuned: Estimate at the point shown.
        default: Probability of the default, by a few independent flights.
        tuned_count: Number of confirmation flights, at the point shown.
        default_count: Number of confirmation flights of the default.
    """

    scenario: str
    confidence: float
    smallest: float
    width: float
    tuned: TailEvent
    default: TailEvent
    tuned_count: ShareCount
    default_count: ShareCount
