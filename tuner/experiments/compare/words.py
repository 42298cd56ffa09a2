"""The results of a comparison as plain sentences, each made from numbers; nothing is called better but by the rule."""

from collections.abc import Iterable

from objectives.risk.differences import BETTER, NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE, WORSE
from plant.quadrotor.scenarios import CONFIRMATION
from tuner.documents.parts import SampledValue
from tuner.experiments.compare.result import Result
from tuner.study.comparison import Quantity
from tuner.text.numbers import estimate, per_cent, significant
from tuner.text.sentences import listing
from tuner.text.units import after_number


def sentences(result: Result) -> list[str]:
    """Return the sentences on a comparison's result."""
    return [*finding_words(result), *closing_words(result)]


def finding_words(result: Result) -> list[str]:
    """Return the sentences on objectives, fronts and limits."""
    return [*objective_words(result), *front_words(result), *limit_words(result)]


def closing_words(result: Result) -> list[str]:
    """Return the sentences on gains at an end, cost and certainty."""
    return [*bound_words(result), *cost_words(result), *certainty_words(result)]


def objective_words(result: Result) -> Iterable[str]:
    """Rank the contenders in each objective: the lowest value, and the word on it beside each other one."""
    for i, quantity in enumerate(result.study.quantities):
        if quantity.kind == "objective" and len(result.names) > 1:
            yield _ranking(result, i, quantity)


def _ranking(result: Result, i: int, quantity: Quantity) -> str:
    values = [row[i].value for row in result.comparison.estimates]
    order = sorted(range(len(values)), key=lambda k: (values[k], k))
    best, others = order[0], order[1:]
    best_estimate = result.comparison.estimates[best][i]
    where = " at the points compared" if result.fronts else ""
    text = f"{quantity.label}{where}: {result.names[best]} has the lowest value, {_spanned(best_estimate, _unit(quantity))}"
    for word, link in LINKS.items():
        names = [
            result.names[other] + (_share_less(result, i, best, other) if word == BETTER else "")
            for other in others
            if result.comparison.word(best, other, i) == word
        ]
        text += f"; {word} {link} {listing(names)}" if names else ""
    return f"{text}."


LINKS = {BETTER: "than", NO_PRACTICAL_DIFFERENCE: "to", NOT_DISTINGUISHABLE: "from", WORSE: "than"}
"""Word on a difference -> preposition before the other one."""


def _share_less(result: Result, i: int, best: int, other: int) -> str:
    """Return the share by which the best is lower: " (75 % less)"."""
    value = result.comparison.estimates[other][i].value
    return f" ({per_cent(-result.comparison.difference(best, other, i).value / value)} less)" if value > 0.0 else ""


def front_words(result: Result) -> Iterable[str]:
    """Compare the sizes of the fronts."""
    volumes = result.volumes
    if volumes is None:
        return
    shares = [f"{name} {_spanned(entry)}" for name, entry in zip(result.names, volumes.volumes, strict=True)]
    yield (
        "Share of the common box that each front dominates (the more the better, reference 1.1 times the nadir of all "
        f"fronts): {listing(shares)}."
    )
    level = [pair[:2] for pair in volumes.differences if volumes.larger(*pair) is None]
    if level:
        pairs = listing(f"{result.names[a]} and {result.names[b]}" for a, b in level)
        yield f"Neither of these fronts is shown to be larger: {pairs}."


def limit_words(result: Result) -> Iterable[str]:
    """Say what each front offers under the middle limit."""
    objectives = [quantity for quantity in result.study.quantities if quantity.kind == "objective"]
    for best in result.best_under:
        limits = sorted({entry.limit for entry in result.best_under if entry.objective == best.objective})
        middle = limits[len(limits) // 2]
        if best.limit != middle:
            continue
        parts = []
        for front, row, name in zip(result.fronts, best.rows, result.names, strict=True):
            if row is None:
                parts.append(f"{name} none")
                continue
            low, high = float(front.low[row, best.objective]), float(front.high[row, best.objective])
            parts.append(f"{name} {_spanned(SampledValue(float(front.values[row, best.objective]), low, high))}")
        wanted, held = objectives[best.objective], objectives[best.subject_to]
        limit = f"{significant(best.limit, 3)}{_unit(held)}"
        yield (
            f"Lowest {wanted.label}{_bracketed(wanted)} with {held.label} at most {limit}, picked on held-out flights: "
            f"{listing(parts)}."
        )


def bound_words(result: Result) -> Iterable[str]:
    """Name recommended gains at an end of their range."""
    for name, best_estimate in zip(result.names, result.bounds, strict=True):
        for entry in best_estimate:
            if entry.recommended:
                why = "beyond which it has no meaning" if entry.natural else "so its range decided it, not the search"
                yield (
                    f"{name}: {entry.variable} = {significant(entry.value, 3)} stands at the {_END[entry.end]} end of its "
                    f"range, {why}."
                )


_END = {"low": "lower", "high": "upper"}


def cost_words(result: Result) -> Iterable[str]:
    """Say what a control step costs."""
    operations = _counts(result.names, [cost.operations for cost in result.costs])
    yield f"Scalar operations of the laws in one control step, counted: {operations}."
    counted_costs = {
        name: cost.processor for name, cost in zip(result.names, result.costs, strict=True) if cost.processor
    }
    if counted_costs:
        instructions = _counts(list(counted_costs), [round(cost.instructions_step) for cost in counted_costs.values()])
        target = next(iter(counted_costs.values())).target
        yield f"Instructions of the whole control step on a {target}, mean in flight, counted: {instructions}."


def _counts(names: list[str], counts: list[int]) -> str:
    """Return counts in rising order, each with the names that have it."""
    return "; ".join(
        f"{count} with {listing(name for name, own_count in zip(names, counts, strict=True) if own_count == count)}"
        for count in sorted(set(counts))
    )


def certainty_words(result: Result) -> Iterable[str]:
    """Say which contenders lost flights, and what many intervals mean."""
    for name, lost in zip(result.names, result.flown.failed.mean(axis=1), strict=True):
        if lost > 0.0:
            yield f"{name} lost {per_cent(float(lost))} of its flights."
    if result.fronts:
        yield (
            f"Points were picked on held-out flights; every value here is from {flights_of(result.study.stream)}, which "
            "picked nothing."
        )
        yield "Intervals are over flights: every contender was searched once, and another search would end at another front."
    tested = len(result.comparison.differences)
    if tested:
        yield (
            f"Every interval is a 95 % interval by itself: of {tested} paired differences about {round(0.05 * tested)} "
            "would exclude zero if no contender differed from another."
        )


def flights_of(stream: str) -> str:
    """Return the flights of a comparison in words."""
    return f"{'confirmation' if stream == CONFIRMATION else 'comparison'} flights"


def _unit(quantity: Quantity) -> str:
    return after_number(quantity.objective.metric.unit)


def _bracketed(quantity: Quantity) -> str:
    return f" [{_unit(quantity).strip()}]" if _unit(quantity) else ""


def _spanned(best_estimate: SampledValue, unit: str = "") -> str:
    value, span = estimate(best_estimate.value, best_estimate.low, best_estimate.high)
    return f"{value}{unit} {span}"
