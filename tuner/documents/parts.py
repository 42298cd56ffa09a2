"""Parts that several documents share."""

from collections.abc import Iterator
from typing import Any, Self, TypeVar

import numpy as np
from pydantic import ConfigDict

from objectives.risk import clopper_pearson
from objectives.scales import DECIBEL, SCALES
from tuner.store.document import Document, DocumentPart
from tuner.text.numbers import significant
from tuner.text.units import in_degrees

ENDS = ("value", "low", "high")
# Fields of a row whose numbers have the row's unit.
NUMBERS = ("limit", "relaxed", "value", "default", "tuned", "unrounded", "held")


class SampledValue(DocumentPart):
    """A number with its 95 % interval, in this order."""

    value: float
    low: float
    high: float

    def __init__(self, *parts: float, **named: Any) -> None:
        super().__init__(**dict(zip(ENDS, parts, strict=False)), **named)

    def __iter__(self) -> Iterator[float]:  # pyright: ignore[reportIncompatibleMethodOverride]
        return iter((self.value, self.low, self.high))


class Estimate(DocumentPart):
    """A number with its 95 % interval, in this order; null where there is none."""

    value: float | None
    low: float | None
    high: float | None

    def __init__(self, *parts: float | None, **named: Any) -> None:
        super().__init__(**dict(zip(ENDS, parts, strict=False)), **named)

    @property
    def parts(self) -> tuple[float | None, float | None, float | None]:
        """Value and ends, as `tuner.text.numbers.estimate` takes them."""
        return (self.value, self.low, self.high)

    def __iter__(self) -> Iterator[float | None]:  # pyright: ignore[reportIncompatibleMethodOverride]
        return iter((self.value, self.low, self.high))


class ShareCount(DocumentPart):
    """Flights with 1 of a quantity that is 0 or 1, among all of them; upper: end of the 95 % interval of their share."""

    events: int
    flights: int
    upper: float

    @classmethod
    def of(cls, samples: np.ndarray) -> Self:
        """Return the count of samples (flights,)."""
        events = int(np.count_nonzero(samples, axis=0))
        return cls(events=events, flights=len(samples), upper=float(clopper_pearson(events, len(samples)).high))

    @property
    def words(self) -> str:
        """The count, and the bound where none was seen: "0 of 256: at most 1.4 %"."""
        bound = "" if self.events else f": at most {significant(100.0 * self.upper, 2)} %"
        return f"{self.events} of {self.flights}{bound}"


class LostFlight(DocumentPart):
    """A flight that ended before its time. name: STREAM-INDEX, by which `tuner fly --flight` flies it again.

    point: whose flight it is, "" where there is but one. time: of its end [s]. cause: what left its limit. limit: in words.
    """

    name: str
    scenario: str
    stream: str
    index: int
    point: str = ""
    time: float
    cause: str
    limit: str

    @property
    def words(self) -> str:
        """The flight in a line."""
        whose = f" of {self.point}" if self.point else ""
        return f"{self.name}{whose} ({self.scenario}): {self.cause} after {self.time:.4g} s, limit {self.limit}"


class LawNames(DocumentPart):
    """The control law of each loop, by name."""

    position: str
    attitude: str


class NumberWithUnit(DocumentPart):
    """A number and its unit."""

    value: float
    unit: str


class PlantStep(DocumentPart):
    """Integration of the plant: equal Runge-Kutta steps [s] in a control period, and their error as far as it was estimated.

    fixed: the study writes the step. error: largest of any metric's mean, in standard errors of its held-out mean [1], where
    flights differ; metric: that has it. relative_error: largest as a share of a metric where flights do not differ [1];
    relative_metric: that has it. margin_error: largest share by which a margin of the loop that flies is off the exact one [1], 1
    where one of the two is unstable; margin: that has it. Each null where there is none. ended_otherwise: of the `flights` flown
    to find out, those that end otherwise with steps half as long. advised: a step that is short enough [s]; null where this is.
    """

    step: float
    steps: int
    fixed: bool
    flights: int
    error: float | None = None
    metric: str | None = None
    relative_error: float | None = None
    relative_metric: str | None = None
    margin_error: float | None = None
    margin: str | None = None
    ended_otherwise: int = 0
    advised: float | None = None

    @property
    def words(self) -> str:
        """Steps and error in a line."""
        count = "1 step" if self.steps == 1 else f"{self.steps} steps"
        who = ", fixed by the study" if self.fixed else ""
        shares = [
            (self.error, f"the standard error of the held-out mean ({self.metric})"),
            (self.relative_error, f"the value ({self.relative_metric})"),
            (self.margin_error, f"a margin ({self.margin})"),
        ]
        errors = [f"{significant(100.0 * error, 1)} % of {of}" for error, of in shares if error is not None]
        error = f"error up to {', '.join(errors)}" if errors else "error not estimated (`tuner plan` does)"
        length = f"{1000.0 * self.step:.4g} ms" if self.step < 1.0 else f"{self.step:.4g} s"
        return f"{count} of {length} a control period{who}; {error}"


class GainValue(NumberWithUnit):
    """A gain in the unit of the study file."""


class ReadGain(GainValue):
    """A gain of gains.json, of which readers of a folder need value and unit."""

    model_config = ConfigDict(extra="ignore")


class RecommendedGains(Document):
    """Gains of a gains.json; the rest of it is read by `tuner.gains`."""

    model_config = ConfigDict(extra="ignore")
    gains: dict[str, ReadGain]


Row = TypeVar("Row", bound=DocumentPart)


def in_shown_units(row: Row) -> Row:
    """Return a row with its numbers in its shown_unit, as `unit`; a row without one as it is.

    A difference is that of shown numbers.
    """
    name = getattr(row, "shown_unit", None)
    if name is None:
        return row
    scale = SCALES[name]

    def shown(entry: Any) -> Any:
        if isinstance(entry, Estimate):
            return Estimate(*map(shown, entry))
        return None if entry is None else float(scale.shown(entry))

    def converted(part: Row) -> Row:
        names = set(NUMBERS) & set(type(part).model_fields)
        return part.model_copy(update={name: shown(getattr(part, name)) for name in names})

    new = converted(row).model_copy(update={"unit": scale.unit})
    if states := getattr(row, "states", None):
        new = new.model_copy(update={"states": [converted(state) for state in states]})
    difference = getattr(row, "difference", None)
    if isinstance(difference, Estimate) and difference.value is not None:
        gap = new.tuned.value - new.default.value  # pyright: ignore[reportAttributeAccessIssue]
        new = new.model_copy(update={"difference": Estimate(gap, difference.low, difference.high)})
    return new


def is_level(row: DocumentPart) -> bool:
    """Return True for a factor that is shown as its level in dB."""
    return getattr(row, "shown_unit", None) == DECIBEL.unit


def on_page(row: Row, *names: str) -> Row:
    """Return a row in the units of the page: levels in dB, and these numbers in degrees if they are angles."""
    return in_shown_units(row) if is_level(row) else row_in_degrees(row, *names)


def numbers_on_page(row: DocumentPart, numbers: np.ndarray) -> np.ndarray:
    """Return numbers of a row's quantity in the units of the page."""
    return DECIBEL.shown(numbers) if is_level(row) else numbers * in_degrees(row.unit).factor  # pyright: ignore[reportAttributeAccessIssue]


def scaled(row: Row, factor: float, *names: str) -> Row:
    """Return a row with these numbers times a factor, estimates with their ends; null stays null."""
    return row.model_copy(update={name: _times(getattr(row, name), factor) for name in names})


def row_in_degrees(row: Row, *names: str) -> Row:
    """Return a row with a unit with these numbers, which have it, in degrees if they are angles; no unit is ""."""
    unit, factor = in_degrees(row.unit)  # pyright: ignore[reportAttributeAccessIssue]
    return scaled(row, factor, *names).model_copy(update={"unit": unit})


def _times(entry: Any, factor: float) -> Any:
    if isinstance(entry, Estimate):
        return Estimate(*[_times(part, factor) for part in entry])
    return None if entry is None else entry * factor
