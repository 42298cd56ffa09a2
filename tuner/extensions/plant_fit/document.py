"""The document of `tuner fit --json`: a plant out of measured inputs and outputs."""

from tuner.store.document import Document, DocumentPart


class RecordRow(DocumentPart):
    """A record: file, digest, samples, duration and mean sampling interval [s], and what its reader had to assume."""

    file: str
    sha256: str
    samples: int
    duration: float
    period: float
    notes: list[str]


class PlantNumber(DocumentPart):
    """A number of a transfer function with its 95 % interval.

    Ends are null without an interval.
    """

    input: str
    name: str
    value: float
    low: float | None
    high: float | None
    unit: str
    identified: bool


class RivalRow(DocumentPart):
    """A structure: parameters, fit to all of the record and to held-out blocks [1], and their mean square over the best's.

    error: standard error of that ratio.
    """

    structure: str
    parameters: int
    fit: float
    held_out: float
    ratio: float
    error: float
    chosen: bool


class TransferFunctionRow(DocumentPart):
    """Coefficients from the highest power of s, and dead time [s]."""

    input: str
    numerator: list[float]
    denominator: list[float]
    dead_time: float


class NoiseRow(DocumentPart):
    """Noise of an output, rms in its unit, and correlation time [s].

    Attributes:
        prediction_error: Rms of the errors of one-step prediction.
        correlated: Share of their autocorrelations beyond the 95 % bound.
        order: Number of coefficients of the noise model.
        outliers: Number of samples that the fit leaves out.
    """

    white: float
    coloured: float
    correlation_time: float
    prediction_error: float
    correlated: float
    order: int
    outliers: int


class OutputRow(DocumentPart):
    """The plant of an output. fit: 1 - |y - model| / |y - mean| [1]. notes: what the data do not show, and what would."""

    output: str
    unit: str
    structure: str
    fit: float
    held_out: float
    transfer_functions: list[TransferFunctionRow]
    numbers: list[PlantNumber]
    rivals: list[RivalRow]
    noise: NoiseRow
    notes: list[str]


class PlantFitDocument(Document):
    """A fitted plant. file: study that was written, null without one."""

    records: list[RecordRow]
    inputs: list[str]
    outputs: list[OutputRow]
    warnings: list[str]
    file: str | None = None
