"""The document of `tuner check GAINS --json`: a controller against the hard limits of a study."""

from typing import Annotated, Literal

from tuner.documents.parts import ShareCount
from tuner.store.document import Document, DocumentPart, OneOf, Sense


class JudgedRow(DocumentPart):
    """One limit; null limit: an objective, reported alone.

    value: null where infinite; low, high: ends of the 95 % interval, null where there is none; flights: that it rests on, 0 for
    what is known without flying; count: of a quantity that is 0 or 1; state: steady state in which a margin is worst, null where
    one alone was looked at.
    """

    label: str
    kind: Literal["constraint", "requirement", "objective"]
    quantity: str
    unit: str
    shown_unit: str | None = None
    sense: Sense
    limit: float | None
    value: float | None
    low: float | None
    high: float | None
    flights: int
    verdict: str
    count: ShareCount | None = None
    state: str | None = None


class JudgementDocument(Document):
    """The judgement; verdict: the worst of its rows'; gains, requirements: files; stream: of the scenarios flown."""

    verdict: Annotated[str, OneOf(("pass", "not certain", "fail"))]
    gains: str
    requirements: str
    digest: str
    seed: int
    stream: str
    flights: int
    rows: list[JudgedRow]
