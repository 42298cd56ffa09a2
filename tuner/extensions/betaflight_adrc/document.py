"""The document of `tuner adrc --json`: margins of a tune, the axis that rings, and changes."""

from typing import Literal

from tuner.store.document import Document, DocumentPart


class PlantRow(DocumentPart):
    """Plant of an axis.

    Attributes:
        gain: Acceleration per unit of output [deg/s2].
        lag, dead_time, zero: Time constants [s].
        b0: Gain from output to rate'' [deg/s3].
        intervals: Ends of 95 % intervals out of a log, by the names above; empty without one.
        source: Origin: "given", "log", or "b0" for one scaled by b0.
    """

    axis: str
    gain: float
    lag: float
    dead_time: float
    zero: float
    b0: float
    intervals: dict[str, list[float]]
    source: str


class RingRow(DocumentPart):
    """Margins of an axis in one condition.

    Attributes:
        throttle: Collective, 0 to 1.
        gate: "open" in flight, "shut" on the ground.
        pack: Voltage of the pack, over that of the plants.
        gain_margin: Factor to the gain that rings, null without any; below 1 the loop rings.
        ring: Frequency there [Hz].
        phase_margin: Phase margin [rad].
    """

    axis: str
    schedule: str
    throttle: float
    gate: str
    pack: float
    gain_margin: float | None
    ring: float | None
    phase_margin: float | None


class ChangeRow(DocumentPart):
    """A change that raises the smallest gain margin.

    Attributes:
        gain_margin: Gain margin of the axis after it.
        ring: Frequency at which it then rings [Hz].
        stiffness: Loop gain at 2 Hz over the present one.
        noise: Output from white noise of the gyro over the present one.
    """

    settings: dict[str, float]
    gain_margin: float
    ring: float
    stiffness: float
    noise: float


class DesignRow(DocumentPart):
    """The stiffest tune of an axis with a gain margin.

    Attributes:
        wanted: Gain margin that the tune keeps.
        gain_margin, ring, phase_margin: Margins at the throttle and pack of the largest loop gain; frequency [Hz], phase [rad].
        bandwidth: Crossover at hover [Hz].
        stiffness: Loop gain at 2 Hz over that of the file's tune.
        noise: Output from white noise of the gyro over that of the file's tune.
    """

    axis: str
    wanted: float
    wc: float
    wo: float
    gain_margin: float
    ring: float
    phase_margin: float
    bandwidth: float
    stiffness: float
    noise: float


class AdrcDocument(Document):
    """Forecast of a tune.

    Attributes:
        is_limit: Whether every plant is the craft's own, so that a margin of 1 is a limit; otherwise an order of tunes.
        loop_rate: Rate of the loop [Hz].
        growth: Exponent of the acceleration gain over the collective.
        design: Front of tunes by margin, empty where none is requested.
        worst: Place in `rings` of the smallest margin in flight under the tune's own schedule.
        sentence: The answer in words.
    """

    format: Literal["gainproof-adrc"]
    version: Literal["0.1"]
    file: str
    profile: int
    build: str
    revision: str
    schedule: str
    is_limit: bool
    loop_rate: float
    growth: float
    plants: list[PlantRow]
    rings: list[RingRow]
    worst: int
    changes: list[ChangeRow]
    design: list[DesignRow]
    sentence: str
    notes: list[str]
