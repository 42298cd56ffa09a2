"""The verdict of a second opinion: reasons not to fly, significant differences of flights, limits of the loops.

Do not fly: a loop is unstable, or a factor below 1.3 of its gain makes it so, for thrust moves by 30 % with charge and load; its
peak sensitivity grows beyond 2; a rule of the firmware's own tools refuses the change; flights are lost. A difference counts
where all of the 95 % interval of the paired flights lies beyond 5 %, of noise 10 %. Where no airframe is named, loops are those
of the middle of a class, so margins refuse only what the change made worse, and losses where most vehicles are lost.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from objectives.risk.shares import clopper_pearson
from tuner.analysis.judging.firmware_rules import GROWTH, MAX_MS
from tuner.documents.assessment import (
    BETTER,
    DO_NOT_FLY,
    MIXED,
    NO_OBJECTION,
    NOT_DISTINGUISHABLE,
    WITHIN_LIMITS,
    WORSE,
    AssessedAirframe,
    AssessedLoop,
    AssessedMetric,
    LoopFigures,
    RuleRow,
)
from tuner.documents.margins import LimitRow
from tuner.documents.parts import SampledValue, ShareCount, in_shown_units
from tuner.text.numbers import significant

MIN_GAIN_MARGIN = 1.3
"""Least factor by which the loop gain must be free to change either way."""
TOLERANCE, TOLERANCES = 0.05, {"noise": 0.1}
"""Share of a metric that a difference must exceed to count: of most, and of some."""
MAX_LOSS, MAX_CLASS_LOSS = 0.01, 0.5
"""Largest probability of loss, and largest share of lost vehicles of a class."""


@dataclass(frozen=True)
class Evidence:
    """What a verdict rests on.

    Attributes:
        airframe: The vehicle that was assumed.
        loops: Loops whose gains are in the file.
        violated: Usual limits of these loops that the gains violate.
        rules: Of the firmware.
        metrics: Means over the flights.
        lost_after: Lost flights.
        lost_before: The same before, None without a file before.
        loss_difference: Probability of loss, after less before, with its interval; None without a file before.
        unmodeled: Number of changed parameters that no loop of the model has.
    """

    airframe: AssessedAirframe
    loops: Sequence[AssessedLoop]
    violated: Sequence[LimitRow]
    rules: Sequence[RuleRow]
    metrics: Sequence[AssessedMetric]
    lost_after: ShareCount
    lost_before: ShareCount | None
    loss_difference: SampledValue | None
    unmodeled: int


def form_opinion(evidence: Evidence) -> tuple[str, list[str]]:
    """Return the verdict and its reasons, the most severe first."""
    if refusals := list(reasons_not_to_fly(evidence)):
        return DO_NOT_FLY, refusals
    if evidence.lost_before is None:
        limits = [limit_text(row) for row in evidence.violated] + [rule_text(row) for row in violated_rules(evidence)]
        is_clean = not limits and evidence.lost_after.events == 0 and evidence.airframe.is_known
        return (WITHIN_LIMITS if is_clean else NO_OBJECTION), limits
    verdicts = {row.verdict for row in evidence.metrics}
    verdict = next(
        word
        for word, is_met in (
            (MIXED, {BETTER, WORSE} <= verdicts),
            (WORSE, WORSE in verdicts),
            (BETTER, BETTER in verdicts),
            (NOT_DISTINGUISHABLE, True),
        )
        if is_met
    )
    return verdict, [metric_text(row) for row in evidence.metrics]


def opinion_sentence(evidence: Evidence, verdict: str, reasons: Sequence[str]) -> str:
    """Return the verdict in one sentence, with the vehicle that it holds for."""
    loss = f"lost {evidence.lost_after.words}"
    if evidence.lost_before is not None:
        loss += f" (before: {evidence.lost_before.words})"
    said = "; ".join([*reasons, *([] if verdict == DO_NOT_FLY else [loss])])
    vehicle = evidence.airframe
    where = "" if vehicle.is_known else f", on the {vehicle.title}: {vehicle.ranges}"
    changed = f"{evidence.unmodeled} changed parameter{'s' if evidence.unmodeled > 1 else ''}"
    beyond = f", without {changed} outside the model" if evidence.unmodeled else ""
    return f"{verdict[0].upper()}{verdict[1:]}: {said}{beyond}{where}."


def reasons_not_to_fly(evidence: Evidence) -> Iterator[str]:
    """Yield the reasons not to fly."""
    for loop in evidence.loops:
        if reason := _unstable_reason(loop, evidence.airframe.is_known):
            yield reason
    ruled = {row.axis for row in evidence.rules if row.refuses}
    yield from (rule_text(row) for row in evidence.rules if row.refuses)
    yield from (
        _fragile_text(loop) for loop in evidence.loops if loop.channel not in ruled and has_become_fragile(loop)
    )
    lost, difference = evidence.lost_after, evidence.loss_difference
    if difference is not None and difference.low > 0.0:
        before = "" if evidence.lost_before is None else f", {evidence.lost_before.words} before"
        yield f"more flights are lost: {lost.words}{before}"
    elif is_lost_too_often(lost, evidence.airframe.is_known):
        yield f"flights are lost: {lost.words}"


def _unstable_reason(loop: AssessedLoop, is_known: bool) -> str:
    """Return the sentence on a loop that is unstable or nearly so, "" for any other."""
    margin = least_gain_margin(loop.after)
    if loop.after.stable and (margin >= MIN_GAIN_MARGIN or not (is_known or _shrinks(loop))):
        return ""
    if not loop.after.stable:
        return f"the {loop.channel} loop is unstable" if is_known or _shrinks(loop) else ""
    factor = significant(margin, 3)
    return f"a factor of {factor} of its gain makes the {loop.channel} loop unstable, min {MIN_GAIN_MARGIN:g}"


def _shrinks(loop: AssessedLoop) -> bool:
    """Return True if a change lowers the gain margin."""
    return loop.before is not None and least_gain_margin(loop.after) * GROWTH < least_gain_margin(loop.before)


def least_gain_margin(loop: LoopFigures) -> float:
    """Return the lesser gain margin as a factor: 1 of an unstable loop, infinite where nothing limits it."""
    if not loop.stable:
        return 1.0
    return min((margin for margin in (loop.gain_up, loop.gain_down) if margin is not None), default=float("inf"))


def has_become_fragile(loop: AssessedLoop) -> bool:
    """Return True if a change raises the peak sensitivity beyond 2."""
    if loop.before is None or loop.after.ms is None or loop.before.ms is None:
        return False
    return loop.after.ms > MAX_MS and loop.after.ms > GROWTH * loop.before.ms


def is_lost_too_often(lost: ShareCount, is_known: bool) -> bool:
    """Return True if the probability of loss is significantly above what may be flown."""
    low = float(clopper_pearson(lost.events, lost.flights).low)
    return low > (MAX_LOSS if is_known else MAX_CLASS_LOSS)


def compare_means(metric: str, difference: SampledValue) -> str:
    """Return the verdict on a difference [share of the mean before]: its interval lies beyond the tolerance, or not."""
    tolerance = TOLERANCES.get(metric, TOLERANCE)
    if difference.low <= tolerance and difference.high >= -tolerance:
        return NOT_DISTINGUISHABLE
    return WORSE if difference.low > tolerance else BETTER


def violated_rules(evidence: Evidence) -> list[RuleRow]:
    """Return the violated rules."""
    return [row for row in evidence.rules if row.verdict == "violated"]


def rule_text(row: RuleRow) -> str:
    """Return a violated rule in words."""
    value = "unstable" if row.value is None else significant(row.value, 3)
    unit = "" if row.unit == "1" else f" {row.unit}"
    note = f"{row.note}; " if row.note else ""
    return f"{row.rule}, {row.axis}: {value}{unit}, {row.sense} {row.limit:g}{unit} ({note}{row.source})"


def limit_text(row: LimitRow) -> str:
    """Return a violated limit in words."""
    shown = in_shown_units(row)
    unit = "" if shown.unit == "1" else f" {shown.unit}"
    return f"{shown.label} {significant(shown.value, 3)}{unit}, {shown.sense} {significant(shown.limit, 3)}{unit}"


def metric_text(row: AssessedMetric) -> str:
    """Return a compared mean in words."""
    if row.difference is None:
        return f"{row.metric} {significant(row.after)}"
    value, low, high = (significant(100.0 * part, 3) for part in row.difference)
    return f"{row.metric} {value} % [{low}, {high}]"


def _fragile_text(loop: AssessedLoop) -> str:
    assert loop.before is not None
    figures = (significant(part.ms, 3) for part in (loop.after, loop.before))
    return "peak sensitivity Ms, {channel}: {}, max {limit:g} ({} before)".format(
        *figures, channel=loop.channel, limit=MAX_MS
    )
