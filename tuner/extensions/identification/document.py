"""The documents of `tuner identify --json`: a vehicle out of logs, and what is wrong with a log."""

from typing import Annotated

from pydantic import Field

from tuner.store.document import Document, DocumentPart, OneOf

QUIET = 0.3
"""RMS of an output on windows kept from the fit, over that on windows of the fit, below which they say nothing of it."""


class LogRow(DocumentPart):
    """A log: file, kind, digest, the flight used [s], samples a second, samples lost, and what its reader had to assume."""

    file: str
    kind: str
    sha256: str
    begin: float
    end: float
    rate: float
    lost: int
    notes: list[str] = Field(alias="said")


class IdentifiedNumber(DocumentPart):
    """A number of the vehicle with its 95 % interval; prior: with that of its own.

    identified: whether the data moved it; reason: why not, "" where they did.
    """

    name: str
    meaning: str
    unit: str
    value: float
    low: float
    high: float
    prior: float
    prior_low: float
    prior_high: float
    identified: bool
    reason: str


class PredictionRow(DocumentPart):
    """Prediction of an output over windows that were kept from the fit: share of variance explained, RMS error in the unit.

    covered: share of what was measured inside the 95 % band. correlated: share of the autocorrelations of what the noise model
    leaves over that are beyond their 95 % bound. reach: frequency [Hz] up to which more than half of the power is explained.
    moved: RMS of what was measured there over that on windows of the fit, null in files of version 0.2.0 and before.
    """

    output: str
    explained: float
    error: float
    unit: str
    covered: float
    correlated: float
    reach: float
    moved: float | None = None

    @property
    def is_quiet(self) -> bool:
        """Whether the windows hold too little of the output."""
        return self.moved is not None and self.moved < QUIET


class RegressionRow(DocumentPart):
    """An inertia [kg m2] from ordinary least squares, one way and the other."""

    axis: str
    acceleration_on_torque: float
    torque_on_acceleration: float


class ResponseRow(DocumentPart):
    """Frequency response of an output to the motor commands of its axis.

    Next to that of the logs stands that of the model; rates are in rad/s, lift is in m/s2, commands are shares of full command.

    Attributes:
        instrument: "setpoint", or "" where the command is its own.
        averages: Independent segments.
        frequency: [Hz].
        magnitude: [dB].
        phase: [degrees].
        coherence: Coherence of instrument and output.
        half_width: Half-width of the 95 % interval of the magnitude [dB]; 1 dB of it is 6.6 degrees of the phase.
        model_magnitude: [dB].
        model_phase: [degrees].
        model_half_width: Half-width of the 95 % interval of the model's magnitude [dB].
        model_phase_half_width: Half-width of the 95 % interval of its phase [degrees].
        compared: Whether coherence, noise and leakage allow to compare the two.
    """

    output: str
    instrument: Annotated[str, OneOf(("", "setpoint"))]
    averages: float
    frequency: list[float]
    magnitude: list[float]
    phase: list[float]
    coherence: list[float]
    half_width: list[float]
    model_magnitude: list[float]
    model_phase: list[float]
    model_half_width: list[float]
    model_phase_half_width: list[float]
    compared: list[bool]


class Posterior(DocumentPart):
    """Estimates of the vehicle's coordinates: logarithms of positive numbers, all others as they are, in SI units.

    covariance: of them, in the order of the names. wide: standard deviations before the first log.
    """

    names: list[str]
    point: list[float]
    covariance: list[list[float]]
    wide: list[float]


class FlightNumber(DocumentPart):
    """A number of one flight with its 95 % interval.

    difference: from the others in standard deviations where it is beyond 1.96, else null.
    """

    name: str
    value: float
    low: float
    high: float
    difference: float | None = None


class FlightRow(DocumentPart):
    """A flight alone: its numbers, and a chi-square test against others.

    The test is null where there are no others.
    """

    flight: str
    numbers: list[FlightNumber]
    statistic: float | None = None
    degrees: float | None = None
    probability: float | None = None


class IdentificationDocument(Document):
    """A vehicle out of logs.

    before: earlier logs, whose posterior was the prior. posterior: what all of them tell, for `tuner identify --update`.

    curve: thrust of a rotor [N] over the motor command, constant, linear and quadratic, each with its interval. correlation: of
    the numbers of `uncertainty`, in this order. horizon: of the windows of prediction [s]. flights: each alone, earlier
    ones first.
    """

    airframe: str
    file: str | None
    logs: list[LogRow]
    numbers: list[IdentifiedNumber]
    curve: list[IdentifiedNumber]
    uncertainty: list[str]
    deviations: list[float]
    correlation: list[list[float]]
    horizon: float
    prediction: list[PredictionRow]
    regressions: list[RegressionRow]
    gyro_noise: list[float]
    warnings: list[str]
    verdict: str
    before: list[LogRow] = []
    posterior: Posterior | None = None
    responses: list[ResponseRow] = []
    flights: list[FlightRow] = []


class LogFinding(DocumentPart):
    """A problem of a log."""

    file: str
    severity: Annotated[str, OneOf(("useless", "mind"))]
    text: str


class LogCheckDocument(Document):
    """Issues of logs; usable: whether all of them can be identified from."""

    airframe: str
    logs: list[LogRow]
    findings: list[LogFinding]
    usable: bool
