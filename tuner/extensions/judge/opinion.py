"""The verdict of a second opinion: reasons not to fly, comparison of paired flights, limits of the loops.

Do not fly: a loop is unstable, or its peak sensitivity is above 4.3, with which a thrust 30 % off may make it so; its peak
sensitivity grows beyond 2; a rule of the firmware's own tools refuses the change; flights are lost. The comparison is of the
paired flights alone, each difference by the rule of `objectives.risk.differences`; less noise for larger errors is "quieter
and softer", the reverse "stiffer and louder"; an error of the first flights that doubles is "worse", and so is noise whose
heat grows tenfold beyond what the errors fall. For the verdict a loop that comes from above 4.3 to at most 2 counts as better,
too. If no airframe is named, loops are those of the middle of a class, so margins of two files refuse only what the change
made worse, those of one file an unstable loop (a peak above 4.3 is not judged: other vehicles of the class are quicker or
weaker), and losses where most vehicles are lost. Losses that come from the wide ranges of a named airframe are not judged
(`spread_losses.py`).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf

from objectives.risk import join_words
from objectives.risk.differences import BETTER, MIXED, WORSE
from tuner.documents.assessment import (
    DO_NOT_FLY,
    NO_OBJECTION,
    NOT_JUDGED,
    SOFTER,
    STIFFER,
    WITHIN_LIMITS,
    AssessedAirframe,
    AssessedLoop,
    AssessedMetric,
    AssessedScenario,
    RuleRow,
)
from tuner.documents.margins import LimitRow
from tuner.documents.parts import in_shown_units
from tuner.extensions.judge.firmware_rules import GROWTH, MAX_MS
from tuner.extensions.judge.scenarios import NOISE
from tuner.extensions.judge.spread_losses import MAX_LOSS, exceeds_limit
from tuner.text.numbers import plus, significant
from tuner.text.units import after_number

FRAGILE_MS = 4.3
"""Largest peak sensitivity of any loop: Ms / (Ms - 1) = 1.3 is the gain margin that it guarantees."""
CLASS_ADVICE = "that is the class's middle, and a tune fits one vehicle: give this one's airframe with --airframe"
MAX_CLASS_LOSS = 0.5
"""Largest share of lost vehicles of a class."""
MAX_ERROR_GROWTH = 1.0
"""Growth of an error, as a share, that no gain elsewhere offsets: MPC_XY_P 0.0001 has +129 % of position for -5 % of noise."""
MAX_HEAT = 10.0
"""Factor on the heat of noise, for the same error, that no gain elsewhere offsets.

A gain times k multiplies the noise of the commands by k, and divides the error after a disturbance by k at best, so an honest
trade leaves their product as it is. The heat of windings goes with the square of the current: here it is the square of that
product. Ten is an order of magnitude; tunes that people fly reach 6 over the firmware's defaults.
"""


@dataclass(frozen=True)
class Evidence:
    """Evidence of a verdict.

    Attributes:
        airframe: The vehicle that was assumed.
        loops: Loops whose gains are in the file.
        violated: Usual limits of these loops that the gains violate.
        rules: Rules of the firmware.
        metrics: Means over the flights of each scenario.
        scenarios: Lost flights of each scenario, the first flight first.
        unmodeled: Number of changed parameters that no loop of the model has.
        spread: Scenario -> reason of losses that come from the airframe's ranges.
    """

    airframe: AssessedAirframe
    loops: Sequence[AssessedLoop]
    violated: Sequence[LimitRow]
    rules: Sequence[RuleRow]
    metrics: Sequence[AssessedMetric]
    scenarios: Sequence[AssessedScenario]
    unmodeled: int
    spread: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def comparison(self) -> str | None:
        """The verdict of the paired flights alone, None without a file before."""
        return compare_flights(self.metrics, [row.loss for row in self.scenarios])


def form_opinion(evidence: Evidence) -> tuple[str, list[str]]:
    """Return the verdict and its reasons, the most severe first."""
    if refusals := list(reasons_not_to_fly(evidence)):
        return DO_NOT_FLY, refusals
    if evidence.spread and evidence.airframe.is_known:
        return NOT_JUDGED, list(evidence.spread.values())[:1]
    if fragile := class_reasons(evidence):
        return NOT_JUDGED, fragile
    if evidence.comparison is None:
        violated = [rule_text(row) for row in evidence.rules if row.verdict == "violated"]
        spread = list(evidence.spread.values())[:1]
        limits = [*spread, *map(limit_text, evidence.violated), *violated]
        is_clean = (
            not limits and evidence.airframe.is_known and not any(row.lost_after.events for row in evidence.scenarios)
        )
        return (WITHIN_LIMITS if is_clean else NO_OBJECTION), limits
    recovered = list(filter(None, map(recovery_text, evidence.loops)))
    trade = evidence.comparison in (SOFTER, STIFFER)
    verdict = evidence.comparison if trade or not recovered else join_words([evidence.comparison, BETTER])
    unpaid = [text] if (text := unpaid_noise_text(evidence.metrics)) else []
    return verdict, [*recovered, *unpaid, *map(metric_text, evidence.metrics)]


def compare_flights(metrics: Sequence[AssessedMetric], losses: Sequence[str | None]) -> str | None:
    """Return the word on paired flights; None for one file.

    Losses decide where one file has fewer, then errors that double, then noise that buys too little, then all means.

    Args:
        metrics: Means over the flights of each scenario, with their words.
        losses: Words on the lost flights of each scenario.
    """
    lost = [word for word in losses if word is not None]
    if not lost:
        return None
    if (word := join_words(lost)) in (BETTER, WORSE, MIXED):
        return word
    if any(map(has_doubled, metrics)) or unpaid_noise_text(metrics):
        return WORSE
    words = [(row.metric, row.verdict) for row in metrics if row.verdict is not None]
    noise, control = (
        join_words([word for metric, word in words if (metric == NOISE) == is_noise]) for is_noise in (True, False)
    )
    trades = {(BETTER, WORSE): SOFTER, (WORSE, BETTER): STIFFER}
    return trades.get((noise, control)) or join_words([word for _, word in words])


def has_doubled(row: AssessedMetric) -> bool:
    """Whether an error of the first flights has surely doubled.

    After a step of torque the error goes with one over the gain: there it doubles with gains halved, which is a trade.
    """
    is_error = row.metric != NOISE and row.scenario is None
    return is_error and row.difference is not None and row.difference.low >= MAX_ERROR_GROWTH


def unpaid_noise_text(metrics: Sequence[AssessedMetric]) -> str:
    """Return the growth of noise beyond the fall of errors, or "".

    Each interval counts by the end that speaks for the change.
    """
    factors = [(row.metric == NOISE, 1.0 + row.difference.low) for row in metrics if row.difference is not None]
    noise = max((factor for is_noise, factor in factors if is_noise), default=1.0)
    error = min([1.0, *(factor for is_noise, factor in factors if not is_noise)])
    if (noise * error) ** 2 < MAX_HEAT:
        return ""
    return f"noise times {significant(noise, 3)}, for errors times {significant(error, 3)} at best"


def opinion_sentence(evidence: Evidence, verdict: str, reasons: Sequence[str]) -> str:
    """Return verdict, reasons and vehicle in one sentence."""
    vehicle, count = evidence.airframe, evidence.unmodeled
    loss = loss_text(evidence.scenarios)
    if verdict not in (DO_NOT_FLY, NOT_JUDGED):
        parts = [*reasons, loss]
    elif evidence.comparison is None:
        parts = reasons
    else:
        flown = "; ".join([*map(metric_text, evidence.metrics), loss])
        parts = [*reasons, f"in flight: {evidence.comparison}: {flown}"]
    beyond = f", without {count} changed parameter{'s' if count > 1 else ''} outside the model" if count else ""
    where = "" if vehicle.is_known else f", on the {vehicle.title}: {vehicle.ranges}"
    return f"{verdict[0].upper()}{verdict[1:]}: {'; '.join(parts)}{beyond}{where}."


def reasons_not_to_fly(evidence: Evidence) -> Iterator[str]:
    """Yield the reasons not to fly."""
    is_known, refusing = evidence.airframe.is_known, [row for row in evidence.rules if row.refuses]
    yield from map(rule_text, refusing)
    stated = {row.axis for row in refusing}
    yield from filter(None, (loop_reason(loop, is_known) for loop in evidence.loops if loop.channel not in stated))
    for scenario in evidence.scenarios:
        limit = MAX_LOSS if is_known and scenario.name not in evidence.spread else MAX_CLASS_LOSS
        if reason := loss_reason(scenario, limit):
            yield reason


def class_reasons(evidence: Evidence) -> list[str]:
    """Return the fragile loops of one file on a class."""
    if evidence.airframe.is_known or evidence.comparison is not None:
        return []
    fragile = [row for row in evidence.loops if FRAGILE_MS < _peak(row.after.ms) < inf]
    texts = [f"{_peak_text(row)}, max {FRAGILE_MS:g}" for row in fragile]
    return [*texts, CLASS_ADVICE] if texts else []


def loss_reason(scenario: AssessedScenario, limit: float) -> str:
    """Return the reason of lost flights, or ""; limit: largest probability of loss."""
    lost, before = scenario.lost_after, scenario.lost_before
    if before is not None and scenario.loss == WORSE:
        return f"more flights are lost ({scenario.name}): {lost.words}, before {before.words}"
    return f"flights are lost ({scenario.name}): {lost.words}" if exceeds_limit(lost, limit) else ""


def loss_text(scenarios: Sequence[AssessedScenario]) -> str:
    """Return lost first flights, and those of scenarios that lose some."""
    first, *further = scenarios
    shown = [first, *(row for row in further if row.lost_after.events or (row.lost_before and row.lost_before.events))]
    texts = []
    for row in shown:
        where = "" if row is first else f" ({row.name})"
        before = "" if row.lost_before is None else f" (before: {row.lost_before.words})"
        texts.append(f"lost{where} {row.lost_after.words}{before}")
    return "; ".join(texts)


def loop_reason(loop: AssessedLoop, is_known: bool) -> str:
    """Return the reason of a fragile loop, or ""; is_known: whether the airframe is."""
    before = None if loop.before is None else _peak(loop.before.ms)
    after = _peak(loop.after.ms)
    has_grown = before is not None and after > GROWTH * before
    limit = MAX_MS if has_grown else FRAGILE_MS
    # The middle of a class is no vehicle: one file that is fragile there is not judged, unless the loop is unstable.
    if after <= limit or not (has_grown or is_known or (before is None and after == inf)):
        return ""
    earlier = "" if before is None else f" ({significant(before, 3)} before)"
    if after == inf:
        return f"the {loop.channel} loop is unstable"
    return f"{_peak_text(loop)}, max {limit:g}{earlier}"


def recovery_text(loop: AssessedLoop) -> str:
    """Return the improvement of a loop that was not to be flown."""
    before, after = inf if loop.before is None else _peak(loop.before.ms), _peak(loop.after.ms)
    if loop.before is None or before <= FRAGILE_MS or after > MAX_MS:
        return ""
    earlier = "unstable" if before == inf else significant(before, 3)
    return f"{_peak_text(loop)} ({earlier} before)"


def _peak_text(loop: AssessedLoop) -> str:
    return f"peak sensitivity Ms, {loop.channel}: {significant(_peak(loop.after.ms), 3)}"


def rule_text(row: RuleRow) -> str:
    """Return a violated rule in words."""
    value = "infinite" if row.value is None else significant(row.value, 3)
    unit, note = after_number(row.unit), f"{row.note}; " if row.note else ""
    return f"{row.rule}, {row.axis}: {value}{unit}, {row.sense} {row.limit:g}{unit} ({note}{row.source})"


def limit_text(row: LimitRow) -> str:
    """Return a violated limit in words."""
    shown = in_shown_units(row)
    unit = after_number(shown.unit)
    return f"{shown.label} {significant(shown.value, 3)}{unit}, {shown.sense} {significant(shown.limit, 3)}{unit}"


def metric_text(row: AssessedMetric) -> str:
    """Return a compared mean in words."""
    if row.difference is None:
        return f"{row.label} {significant(row.after)}"
    value, low, high = (significant(100.0 * part, 3) for part in row.difference)
    return f"{row.label} {plus(row.difference.value)}{value} % [{low}, {high}]"


def _peak(ms: float | None) -> float:
    """Return a peak sensitivity, infinite of an unstable loop."""
    return inf if ms is None else ms
