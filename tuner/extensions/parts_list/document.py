"""The document of an airframe that was estimated from a parts list: `tuner new NAME --mass ... --json`."""

from tuner.store.document import Document, DocumentPart


class EstimatedNumber(DocumentPart):
    """A number of the airframe with its 95 % interval and source."""

    name: str
    unit: str
    value: float
    low: float
    high: float
    source: str


class EstimateDocument(Document):
    """An airframe without a log.

    file: that was written. thrust_to_weight: of the middle of the ranges. verdict: what to do next.
    """

    file: str
    thrust_to_weight: float
    numbers: list[EstimatedNumber]
    verdict: str
