"""margins.json: the stability margins of one controller, loop by loop, in SI units: gains as factors, angles in rad.

An infinite value is null, and `note` says what that means. A channel without a loop is not listed. Channels are x, y, z, roll,
pitch, yaw, or those of a plant of the user's own.
"""

from typing import Annotated, Literal

from pydantic import Field

from tuner.documents.parts import LawNames
from tuner.store.document import Document, DocumentPart, Sense
from tuner.text.product import READ_FORMER

MARGINS_FORMAT, MARGINS_VERSION = "gainproof-margins", "0.2"


class Measure(DocumentPart):
    """A number with its unit."""

    value: float
    unit: str


class Vector(DocumentPart):
    """Three numbers in world axes (east, north, up) with their unit."""

    value: list[float]
    unit: str


class Reading(DocumentPart):
    """A quantity of a loop; frequency: where it is met; case: amplitude at which it is worst, null where it depends on none."""

    value: float | None
    unit: str
    frequency: Measure | None
    case: str | None
    note: str | None


class NotedValue(DocumentPart):
    """A number with its unit; null: without end, as the note says."""

    value: float | None
    unit: str
    note: str | None


class GuaranteedRange(DocumentPart):
    """Factors of the gain and the phase that a disk margin guarantees."""

    low: NotedValue
    high: NotedValue
    phase: NotedValue


class TrimPart(DocumentPart):
    """Steady flight that the loops are linearised in."""

    yaw: Measure
    velocity: Vector
    wind: Vector
    position_held: bool


class ChannelMargins(DocumentPart):
    """Margins of one loop by name; growth: largest real part of its modes; amplitude_dependent: whether it is swept."""

    channel: str
    stable: bool
    growth: NotedValue
    amplitude_dependent: bool
    quantities: dict[str, Reading]
    disk_range: GuaranteedRange


class MultiloopMargins(DocumentPart):
    """Disk margin at all plant inputs (z, roll, pitch, yaw) at once."""

    disk: Reading
    disk_range: GuaranteedRange


class StateValue(DocumentPart):
    """A limited quantity in one steady state, null: infinite."""

    state: str
    value: float | None


class LimitRow(DocumentPart):
    """A requirement of a loop and whether it is kept; channel and quantity: what of the table it is about, null for else.

    state: steady state in which the value is worst, null where one alone was looked at; states: the value in each.
    """

    label: str
    channel: str | None
    quantity: str | None
    value: float | None
    unit: str
    shown_unit: str | None = None
    limit: float
    sense: Sense
    hard: bool
    is_satisfied: bool = Field(alias="kept")
    note: str | None
    state: str | None = None
    states: list[StateValue] = []

    @property
    def worst_state(self) -> str | None:
        """The steady state in which the value is worst."""
        return self.state


class CertificateRow(DocumentPart):
    """Proved number of an axis; null where it proves nothing."""

    axis: str
    name: str
    title: str
    value: float | None
    unit: str
    verified: bool
    why: str
    source: str


class MismatchRow(DocumentPart):
    """How far a factor of the vehicle may go from 1 while a criterion is kept; null: as far as was tried."""

    factor: str
    criterion: str
    low: float | None
    high: float | None
    note: str | None


class SignalAmplitude(DocumentPart):
    """Amplitude of the signal of a nonlinear term of a channel's law."""

    channel: str
    term: str
    value: float
    unit: str


class LimitCycleRow(DocumentPart):
    """An oscillation that sustains itself, by harmonic balance, in these channels; attracts: smaller ones grow into it."""

    channels: list[str]
    frequency: Measure
    amplitudes: list[SignalAmplitude]
    attracts: bool


class MarginsDocument(Document):
    """Content of margins.json; passed: every hard requirement is kept; certificates, mismatch: where they were asked for.

    Of a quadrotor there are airframe, laws and trim, of a plant of the user's own plant, channel_laws and limit_cycles.
    """

    format: Annotated[Literal["gainproof-margins"], READ_FORMER]
    version: Literal["0.2"]
    airframe: str | None = None
    plant: str | None = None
    laws: LawNames | None = None
    channel_laws: dict[str, str] | None = None
    control_period: Measure
    trim: TrimPart | None = None
    channels: list[ChannelMargins]
    multiloop: MultiloopMargins
    requirements: list[LimitRow]
    passed: bool
    limit_cycles: list[LimitCycleRow] | None = None
    certificates: list[CertificateRow] | None = None
    mismatch: list[MismatchRow] | None = None
