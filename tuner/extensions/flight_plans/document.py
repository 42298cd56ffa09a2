"""The document of `tuner identify --plan --json`: an experiment to fly, and what it is to tell."""

from typing import Annotated

from pydantic import Field

from tuner.documents.parts import LawNames
from tuner.store.document import Document, DocumentPart, OneOf


class PlannedExcitation(DocumentPart):
    """An excitation of one axis: what of it is excited, amplitude in the unit, frequencies [Hz], begin and length [s]."""

    axis: Annotated[str, OneOf(("roll", "pitch", "yaw", "lift"))]
    wave: Annotated[str, OneOf(("chirp", "doublets", "steps"))]
    quantity: Annotated[str, OneOf(("angle", "rate", "acceleration"))]
    unit: str
    amplitude: float
    first: float
    last: float
    begin: float
    duration: float


class PlannedNumber(DocumentPart):
    """A number of the vehicle with half-widths of its 95 % intervals: relative of positive numbers, in their unit of others.

    asked: None if it was not requested. before: of the prior; foreseen: after the flight; obtained: what identification gave
    of one simulated flight, and error: how far that was off. reason: why it would stay at its prior, "" where it would not.
    """

    name: str
    meaning: str
    unit: str
    value: float
    relative: bool
    target: float | None = Field(alias="asked")
    before: float
    foreseen: float
    obtained: float
    error: float
    reason: str


class PlannedPeak(DocumentPart):
    """The most that the checked flights came to; limit: None where there is none."""

    name: str
    meaning: str
    unit: str
    peak: float
    limit: float | None


class FlightPlanDocument(Document):
    """An experiment to fly; duration: of the flight [s]; flights: that limits were checked in; files: for the target."""

    airframe: str
    laws: LawNames
    scenario: str
    target: str
    duration: float
    flights: int
    excitations: list[PlannedExcitation]
    numbers: list[PlannedNumber]
    peaks: list[PlannedPeak]
    notes: list[str]
    files: list[str]
    verdict: str
