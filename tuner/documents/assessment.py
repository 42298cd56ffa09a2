"""assessment.json: a second opinion on gains before a vehicle is armed, in SI units."""

from typing import Annotated, Literal

from objectives.risk.differences import BETTER, MIXED, NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE, WORSE
from tuner.documents.parts import NumberWithUnit, SampledValue, ShareCount
from tuner.store.document import Document, DocumentPart, OneOf, Sense
from tuner.text.errors import BROKEN, NO_BASIS

WITHIN_LIMITS, NO_OBJECTION, DO_NOT_FLY = "flyable within limits", "no objection", "do not fly"
NOT_JUDGED = "not judged"
SOFTER = "quieter and softer"
"""Word on less noise with larger errors."""
STIFFER = "stiffer and louder"
"""Word on smaller errors with more noise."""
COMPARISONS = (BETTER, WORSE, MIXED, SOFTER, STIFFER, NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE)
EXIT_CODES = {
    **dict.fromkeys((BETTER, MIXED, SOFTER, STIFFER, NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE), 0),
    **dict.fromkeys((WITHIN_LIMITS, NO_OBJECTION), 0),
    **dict.fromkeys((WORSE, DO_NOT_FLY), BROKEN),
    NOT_JUDGED: NO_BASIS,
}
"""Exit code of each verdict."""
VERDICTS = tuple(EXIT_CODES)
REFUSED = tuple(verdict for verdict, code in EXIT_CODES.items() if code)
"""Verdicts that forbid arming."""


class AssessedFile(DocumentPart):
    """A file of gains.

    source: px4, ardupilot, betaflight, crazyflie or gains. version: of the firmware whose names were read.
    """

    file: str
    source: str
    version: str | None
    sha256: str


class AssessedAirframe(DocumentPart):
    """The vehicle that was assumed.

    is_known: named by the user or by gains.json, not the class of the firmware. ranges: in words.
    """

    name: str
    title: str
    is_known: bool
    ranges: str


class ChangedGain(DocumentPart):
    """A gain that differs. before: null where it is new; ratio: after over before, null where that is not a number."""

    name: str
    unit: str
    before: float | None
    after: float
    ratio: float | None


class ParameterChange(DocumentPart):
    """A parameter that differs.

    before: in the earlier file, or as written. after: in the later file, or on the vehicle. null: not there.
    """

    name: str
    before: str | None
    after: str | None


class LoopFigures(DocumentPart):
    """Margins of one loop: gains as factors, phase in rad, delay in s; null: nothing limits it, or it is not stable."""

    stable: bool
    gain_up: float | None
    gain_down: float | None
    phase_margin: float | None
    delay_margin: float | None
    ms: float | None


class AssessedLoop(DocumentPart):
    """A loop before and after; before: null without a file before."""

    channel: str
    before: LoopFigures | None
    after: LoopFigures


class RuleRow(DocumentPart):
    """A rule of the firmware's own tools. refuses: it is violated, and a reason not to fly; note: what is compared."""

    rule: str
    source: str
    axis: str
    value: float | None
    limit: float
    unit: str
    sense: Sense
    verdict: Annotated[str, OneOf(("satisfied", "violated"))]
    refuses: bool
    note: str


class AssessedMetric(DocumentPart):
    """A risk over the flights of a scenario.

    scenario: null for the first flight. difference: after over before, less 1 (of means the geometric mean of paired flights),
    with its 95 % interval, or null. Without a file before there is no verdict (null).
    """

    metric: str
    risk: str = "mean"
    scenario: str | None = None
    definition: str
    unit: str
    before: float | None
    after: float
    difference: SampledValue | None
    verdict: str | None

    @property
    def label(self) -> str:
        """The metric, with another risk than the mean, and a further scenario."""
        name = self.metric if self.risk == "mean" else f"{self.risk} of {self.metric}"
        return name if self.scenario is None else f"{name} ({self.scenario})"


class AssessedScenario(DocumentPart):
    """Flights of one scenario. loss: word on the probability of loss against that before, null without a file before."""

    name: str
    flights: int
    lost_after: ShareCount
    lost_before: ShareCount | None
    loss: str | None


class AssessmentDocument(Document):
    """A second opinion.

    Attributes:
        comparison: Verdict of the paired flights alone, null without a file before, or where nothing is judged.
        reasons: Reasons of the verdict, the most severe first.
        unmodeled: Differences of the model's loops, and assumptions.
        unmodeled_changes: Changes of parameters that no loop has.
        gyro_noise: Density of the gyro's noise, null where nothing is judged.
        scenario: Name of the first flight.
        flights: Number of first flights of each file.
        lost_after: Lost first flights, null where nothing is judged.
        further: The other scenarios with their lost flights.
        guessed: The source in a sentence, null where it was named.
        rollback: File that restores what was before.
        not_restored: Parameters that it does not hold.
        seconds: Time of each stage [s].
    """

    format: Literal["gainproof-assessment"]
    version: Literal["0.1"]
    verdict: Annotated[str, OneOf(VERDICTS)]
    comparison: Annotated[str, OneOf(COMPARISONS)] | None
    sentence: str
    reasons: list[str]
    unmodeled: list[str]
    unmodeled_changes: list[ParameterChange]
    guessed: str | None
    after: AssessedFile
    before: AssessedFile | None
    airframe: AssessedAirframe
    changes: list[ChangedGain]
    loops: list[AssessedLoop]
    rules: list[RuleRow]
    scenario: str
    seed: int
    flights: int
    gyro_noise: NumberWithUnit | None
    metrics: list[AssessedMetric]
    lost_after: ShareCount | None
    lost_before: ShareCount | None
    further: list[AssessedScenario] = []
    rollback: str | None
    not_restored: list[str]
    seconds: dict[str, float]
