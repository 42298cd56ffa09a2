"""The results of a contest as plain sentences, each made from numbers; nothing is called better but by the rule."""

from collections.abc import Iterable

from objectives.risk.differences import BETTER, NO_PRACTICAL_DIFFERENCE, NOT_DISTINGUISHABLE, WORSE
from plant.quadrotor.scenarios import CONFIRMATION
from tuner.documents.contest_document import ClaimRow, PublishedRow, RungRow
from tuner.documents.parts import SampledValue
from tuner.experiments.contest.halving import LEAD
from tuner.experiments.contest.judging import FAILS, SURVIVES, UNDECIDED
from tuner.experiments.contest.result import Result
from tuner.study.contest import Quantity
from tuner.text.numbers import count, estimate, per_cent, significant
from tuner.text.sentences import listing
from tuner.text.units import after_number


def sentences(result: Result) -> list[str]:
    """Return the sentences on a contest's result."""
    return [
        *rung_words(result),
        *objective_words(result),
        *front_words(result),
        *limit_words(result),
        *published_words(result),
        *claim_words(result),
        *bound_words(result),
        *cost_words(result),
        *certainty_words(result),
    ]


def rung_words(result: Result) -> Iterable[str]:
    """Say which searches went on from each rung, and what that saved."""
    numbers = sorted({row.rung for row in result.rungs})
    for number in numbers:
        rows = [row for row in result.rungs if row.rung == number]
        on, stopped = (listing(_standing(row) for row in rows if row.goes_on is goes_on) for goes_on in (True, False))
        yield f"Rung {number}, {max(row.generations for row in rows)} generations: {on} went on; stopped: {stopped}."
    planned = result.contest.halving.finalists if result.contest.halving else 0
    if numbers and len(result.names) < planned:
        compared = "one finalist is" if len(result.names) == 1 else f"{len(result.names)} finalists are"
        yield (
            f"Of {planned} finalists {compared} compared: the others have nothing within the limits, or are behind by more than "
            f"{per_cent(LEAD)} in every objective, so a comparison would decide nothing."
        )
    if numbers:
        searches = sum(entrant.search_flights for entrant in result.prepared)
        dropped = sum(row.flights for row in result.rungs if not row.goes_on)
        every = len({row.contender for row in result.rungs})
        yield (
            f"Successive halving made {count(searches + dropped)} search flights for {every} contenders; the searches that were "
            f"carried to their end made {count(searches)}. Shares are of the common box of a rung's fronts on search flights."
        )


def _standing(row: RungRow) -> str:
    """Return a contender with its share of the common box."""
    return f"{row.contender} ({f'{row.share:.2f}' if row.feasible else 'nothing feasible'})"


def objective_words(result: Result) -> Iterable[str]:
    """Rank the contenders in each objective: the lowest value, and the word on it beside each other one."""
    for i, quantity in enumerate(result.contest.quantities):
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
    objectives = [quantity for quantity in result.contest.quantities if quantity.kind == "objective"]
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


def published_words(result: Result) -> Iterable[str]:
    """Count the printed numbers inside our distribution over seeds; in all and for each contender."""
    free = [cell for cell in result.published if not cell.fitted]
    fitted = [cell for cell in result.published if cell.fitted]
    if free:
        yield (
            f"Of {len(free)} comparisons with printed numbers, {_inside(free)} lie between the 2.5 and the 97.5 percentile of "
            f"our flights: {listing(_per_contender(result, free))}."
        )
    if fitted:
        yield (
            f"Of {len(fitted)} more with numbers that the study was set to meet, {_inside(fitted)} lie there: "
            f"{listing(_per_contender(result, fitted))}."
        )


def _per_contender(result: Result, cells: list[PublishedRow]) -> Iterable[str]:
    for name in result.names:
        mine = [cell for cell in cells if cell.contender == name]
        if mine:
            yield f"{name} {_inside(mine)} of {len(mine)}"


def _inside(cells: list[PublishedRow]) -> int:
    return sum(cell.inside for cell in cells)


def claim_words(result: Result) -> Iterable[str]:
    """Say which claims hold."""
    for judged in result.claims:
        basis = f" {judged.basis}" if judged.basis else ""
        yield f'The claim "{judged.text}" {_VERDICT[judged.verdict]}{basis}: {_counted(judged)}.'


_VERDICT = {SURVIVES: "survives", FAILS: "fails", UNDECIDED: "is undecided"}


def _counted(judged: ClaimRow) -> str:
    verdicts = [ruling.verdict for ruling in judged.rows]
    kinds = ((SURVIVES, "for it"), (FAILS, "against it"), (UNDECIDED, "without a decision"))
    counts = [f"{verdicts.count(kind)} {words}" for kind, words in kinds if kind in verdicts]
    return f"of {len(verdicts)} paired comparisons {listing(counts)}"


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
            f"Points were picked on held-out flights; every value here is from {flights_of(result.contest.stream)}, which "
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
