"""sensitivity.json: the share of each output that every gain decides, and the folder that holds it."""

from tuner.documents.folder import OpenedFolder
from tuner.documents.parts import SampledValue
from tuner.store.document import Document, DocumentPart, Scale


class SensitivityVariable(DocumentPart):
    """A variable that was sampled; it is uniform on its scale."""

    name: str
    unit: str
    low: float
    high: float
    scale: Scale


class IndexRow(DocumentPart):
    """Sobol indices of a variable for an output on a scale: alone (first) and with all others (total)."""

    scale: str
    output: str
    variable: str
    first: SampledValue
    total: SampledValue


class VarianceShares(DocumentPart):
    """Shares of a variance [%]."""

    gains: float
    scenario: float
    interaction: float


class VarianceRow(DocumentPart):
    """The variance of a metric over the samples that completed every flight; null where nothing could be decomposed."""

    objective: str
    metric: str
    unit: str
    candidates: int
    components_percent: VarianceShares | None
    turbulence_percent: float | None
    sum_of_squares_percent: VarianceShares | None


class SensitivityDocument(Document):
    """Content of sensitivity.json; scales: meaning of each; notes: what to know to read the figures."""

    title: str
    study: str
    digest: str
    seed: int
    base_samples: int
    candidates: int
    flights: int
    seconds: float
    lost_flights_percent: float
    not_worth_flying_percent: float
    scales: dict[str, str]
    variables: list[SensitivityVariable]
    outputs: list[str]
    indices: list[IndexRow]
    variance: list[VarianceRow]
    notes: list[str]


class SensitivityFolder(OpenedFolder[SensitivityDocument]):
    """Results of a sensitivity analysis."""

    kind, noun, main, model = "sensitivity", "a sensitivity analysis", "sensitivity.json", SensitivityDocument
