"""The type of a control law: its tuple types, its three functions, the description of its gains and what it tells of itself."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from plant.laws.continuous import ContinuousForm
from plant.origin import Origin

# All that a law may promise: see `Law.promises`.
PROMISES = frozenset({"tracks", "rejects"})
HELD_COMMAND = "command held over the control period"
"""The sentence that ends every law's `discretisation`."""


def in_loop(unit: str, loop: str) -> str:
    """Return a unit with {y} written out in the loop "attitude" (rad) or "position" (m)."""
    return unit.replace("{y}", "rad" if loop == "attitude" else "m")


@dataclass(frozen=True)
class Span:
    """Default and search range of one gain in one loop."""

    default: float
    low: float
    high: float


@dataclass(frozen=True)
class GainInfo:
    """One gain of a law.

    Attributes:
        symbol: symbol as in the source.
        unit: UCUM-like, with {y} for the unit of the channel (rad or m).
        attitude, position: default and search range in each loop.
        scale: "log" or "linear", how a search should walk the range.
        least: the smallest value that is meaningful at all.
        exclusive: whether that value itself is excluded.
        observer: a pole whose product with the control period is limited.
        cutoff: a frequency [Hz] that must stay below half the sampling rate.
        airframe: a fact of the vehicle that the gains are stated with, which no search changes.
        firmware: a constant of the firmware, which no parameter changes.
        resolution: step of the values that the firmware holds, 0 for none.
        source: reference from which definition and range come.
        integrals: number of integrals over time from an error to the command, -1 for a
            derivative; where b0 is 1 it has the unit of the command, over that of the error.
        optional: its default suits every plant, so that the study of a plant need not give it.
        of_output: stated in units of the loop's output, which the gain `authority` turns into acceleration.
        term: name of the term that is off where the gain is 0, "" where 0 turns none off.
    """

    name: str
    symbol: str
    unit: str
    attitude: Span
    position: Span
    scale: str
    source: str
    meaning: str
    least: float = 0.0
    exclusive: bool = False
    observer: bool = False
    cutoff: bool = False
    airframe: bool = False
    firmware: bool = False
    resolution: float = 0.0
    integrals: int | None = None
    term: str = ""
    of_output: bool = False
    optional: bool = False

    def span(self, loop: str) -> Span:
        """Return default and range for the loop "attitude" or "position"."""
        return self.attitude if loop == "attitude" else self.position

    def unit_in(self, loop: str) -> str:
        """Return the unit in the loop "attitude" (y in rad) or "position" (y in m)."""
        return in_loop(self.unit, loop)


@dataclass(frozen=True)
class Nonlinearity:
    """An odd function of one signal in a law's feedback.

    function(s, constants) -> float is a model function that the law's `step` reaches by its global name, so that a backend
    can put a describing function in its place. unit: of the signal s, with {y} for the unit of the channel.
    """

    name: str
    function: Callable[[Any, Any], Any]
    unit: str

    def unit_in(self, loop: str) -> str:
        """Return the unit of the signal in the loop "attitude" (y in rad) or "position" (y in m)."""
        return in_loop(self.unit, loop)


@dataclass(frozen=True)
class Blocks:
    """Texts in the blocks of a law's diagram, "" for no block.

    Attributes:
        feedback: from errors to the command.
        reference: on the way of the reference.
        measured: on the way of the measurement.
        takes_command: whether that block takes the command too, as an observer does.
    """

    feedback: str = "feedback"
    reference: str = ""
    measured: str = ""
    takes_command: bool = False


@dataclass(frozen=True)
class SuperTwisting:
    """Gains of a super-twisting term: w = -k1 |S|^(1/2) sgn S + v, v' = -k2 sgn S.

    mu: the gain of its linear parts, "" where it has none.
    """

    k1: str
    k2: str
    mu: str = ""


@dataclass(frozen=True)
class Law:
    """A single-input single-output control law for y'' = f + b0 u.

    Attributes:
        Gains, Constants, Memory: NamedTuples of floats.
        prepare(gains, h) -> Constants runs once a flight.
        start(constants, measured, held) -> Memory is the state of a loop at rest at the measured value that holds the
            plant with b0 u = held [y/s2].
        step(memory, constants, channel, setpoint, measured, applied, h) -> (command, Memory) runs every control period.
        gains: one entry for each field of Gains.
        sampling: the discretization with the control period h, in words.
        promises: "tracks": a reference that the channel can fly is flown without error; "rejects": a constant
            disturbance leaves no error.
        nonlinear: all that makes the feedback depend on amplitude; empty for a linear law.
        limits: odd functions f(s, constants) of slope 1 at 0, never larger than s, that take away from large signals
            alone, such as the limit of an integral; f(s, beside, constants) takes away where a second signal is large.
            `step` reaches them by their global names, flights meet them, and margins are of the loop inside of them.

    Of a firmware's law and its gains:
        winds_up: it ignores saturation, and limits alone bound its integrals.
        shared: axes that have one number between them, by gain, as one parameter is.
        axes: default and range of gains that are other ones on an axis, by axis and gain.
        on_airframe(vehicle) -> values of the gains that are facts of the airframe, by gain and axis.

    blocks: of its diagram; its equations stand in the docstring of its file, see `plant.laws.law_text`.

    For proofs and designs, of no effect on flights; a law without an entry is left to flights and margins:
        family: name of the equations that designs and theorems are stated for, such as `pid.FAMILY`; laws of a family
            have the same gains with the same meaning.
        observer: omega_o -> gains (b1, b2, b3) of the law's linear extended state observer in continuous time.
        continuous(gains, from_observer) -> ContinuousForm: the law on matrices; see `Channel.rate_from_observer`.
        sector(gains) -> kappa [1/s]: the part outside the form lies between 0 and kappa S; None where there is none.
        super_twisting: names of the gains of a super-twisting term.

    Of a law in use:
        every: control periods between two of its steps, see `plant.laws.slower`.
        plain: the law that then steps, None for every = 1.
        origin: the file or package that it comes from, None where it is bundled.
    """

    name: str
    title: str
    source: str
    Gains: Any
    Constants: Any
    Memory: Any
    prepare: Callable[..., Any]
    start: Callable[..., Any]
    step: Callable[..., Any]
    gains: tuple[GainInfo, ...]
    sampling: str = field(compare=False)
    promises: frozenset[str] = PROMISES
    nonlinear: tuple[Nonlinearity, ...] = ()
    limits: tuple[Callable[..., Any], ...] = ()
    family: str = field(default="", compare=False)
    observer: Callable[[Any], tuple[Any, Any, Any]] | None = field(default=None, compare=False)
    continuous: Callable[[Any, bool], ContinuousForm] | None = field(default=None, compare=False)
    sector: Callable[[Any], float] | None = field(default=None, compare=False)
    super_twisting: SuperTwisting | None = field(default=None, compare=False)
    winds_up: bool = field(default=False, compare=False)
    shared: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]], compare=False)
    axes: Mapping[str, Mapping[str, Span]] = field(default_factory=dict[str, Mapping[str, Span]], compare=False)
    on_airframe: Callable[..., Mapping[str, Mapping[str, float]]] | None = field(default=None, compare=False)
    blocks: Blocks = field(default=Blocks(), compare=False)
    every: int = 1
    plain: "Law | None" = field(default=None, compare=False)
    origin: Origin | None = field(default=None, compare=False)

    @property
    def discretisation(self) -> str:
        """The difference equations of the law in words; without them a gain means nothing on another processor."""
        return f"{self.sampling}; {HELD_COMMAND}"

    def span(self, gain: GainInfo, axis: str, loop: str) -> Span:
        """Return default and range of a gain on an axis of a loop."""
        return self.axes.get(axis, {}).get(gain.name, gain.span(loop))

    def defaults(self, loop: str) -> dict[str, float]:
        """Return the default gains in the loop "attitude" or "position"."""
        return {gain.name: gain.span(loop).default for gain in self.gains}
