"""The document of `tuner compare-logs --json`: what two flights differ in, and whether the second did what was predicted."""

from typing import Annotated

from pydantic import Field

from tuner.extensions.identification.document import LogRow
from tuner.store.document import Document, DocumentPart, OneOf


class Estimated(DocumentPart):
    """A number with its 95 % interval."""

    value: float
    low: float
    high: float


class ComparedMeasure(DocumentPart):
    """A measure of both logs, and the second over the first.

    told: whether the interval of the ratio leaves out 1. predicted: what 95 % of predicted flights stay below, null where none
    were flown for it; kept: whether the second log can have stayed below it.
    """

    name: str
    meaning: str
    unit: str
    before: Estimated
    after: Estimated
    ratio: Estimated
    change: Annotated[str, OneOf(("less", "more", "not told apart"))] = Field(alias="told")
    predicted: float | None
    is_as_predicted: bool | None = Field(alias="kept")


class LogComparisonDocument(Document):
    """Two flights side by side; flights: predicted ones, 0 where none were asked for."""

    airframe: str
    before: LogRow
    after: LogRow
    flights: int
    measures: list[ComparedMeasure]
    verdict: str
