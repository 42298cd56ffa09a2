"""One limit after the other: value, interval, verdict.

A limit on flights is judged by the value over all of them; its interval says whether another draw could have judged otherwise.
A share that is limited to 0 is judged on the flights made, for no number of them shows that; its bound is printed next to it.
Of a worst case none can be given. Requirements that are known without flying are exact and have no interval.
"""

from math import isfinite

import numpy as np

from objectives.problem import Evaluation, Objective, Problem
from objectives.requirements import Requirement, WorstState, worst_states
from plant.seeds import generator
from tuner.documents.judgement import JudgedRow
from tuner.documents.parts import ShareCount
from tuner.study.study import TuningStudy

Array = np.ndarray
REPLICATES = 2000
PASS, UNCERTAIN, FAIL = "pass", "not certain", "fail"
REPORTED, MET, MISSED = "reported", "target kept", "target missed"
# Kept by the value, broken by the value, but for a target that nothing depends on.
HARD, SOFT = (PASS, FAIL), (MET, MISSED)


def judged_rows(study: TuningStudy, problem: Problem, gains: Array, evaluation: Evaluation) -> list[JudgedRow]:
    """Return constraints, requirements and objectives of one gains row (gains,).

    They come in this order, from its evaluation. The mission floor is no limit here: what is judged need not beat anybody.
    """
    n = len(study.objectives)
    constraints = [
        flown_row(entry.objective, entry.most, evaluation, n + i, study.seed)
        for i, entry in enumerate(study.constraints)
        if not entry.floor
    ]
    states = worst_states(problem.screens, gains)
    requirement_rows = [
        known_row(entry, float(evaluation.requirements[0, i]), states.get(entry.label))
        for i, entry in enumerate(problem.requirements)
    ]
    objectives = [flown_row(entry, None, evaluation, i, study.seed) for i, entry in enumerate(study.objectives)]
    return [*constraints, *requirement_rows, *objectives]


def flown_row(quantity: Objective, most: float | None, evaluation: Evaluation, index: int, root: int) -> JudgedRow:
    """Return the row of a risk over flights; most: its limit, None to report it."""
    scores = evaluation.samples(index, quantity.scenario)[0]
    value = float(quantity.risk.apply(scores))
    low, high = interval(quantity, scores, generator(root, "check/bootstrap", index))
    metric = quantity.metric.metric
    row = JudgedRow(
        label=quantity.label,
        kind="objective" if most is None else "constraint",
        quantity=metric.definition,
        unit=quantity.metric.unit,
        sense="max",
        limit=most,
        value=value,
        low=low,
        high=high,
        flights=len(scores),
        verdict=verdict(most, value, value if quantity.is_binary and most == 0.0 else high),
    )
    return row.model_copy(update={"count": ShareCount.of(scores)}) if quantity.is_binary else row


def verdict(most: float | None, value: float, high: float | None) -> str:
    """Return the verdict on a limit: within `most` it is uncertain where `high`, the interval's upper end, is not."""
    if most is None:
        return REPORTED
    if value > most:
        return FAIL
    return PASS if high is not None and high <= most else UNCERTAIN


def interval(quantity: Objective, scores: Array, draw: np.random.Generator) -> tuple[float | None, float | None]:
    """Return the 95 % interval of a risk over scores (flights,); None for a worst case."""
    if quantity.risk.name == "worst":
        return None, None
    resample = draw.integers(len(scores), size=(REPLICATES, len(scores)), dtype=np.intp)
    low, high = quantity.interval(scores, resample)
    return float(low), float(high)


def known_row(requirement: Requirement, value: float, worst: WorstState | None = None) -> JudgedRow:
    """Return the row of a requirement that is known without flying; a soft one is a target and fails nothing."""
    met, broken = HARD if requirement.hard else SOFT
    phrase = met if requirement.is_satisfied(np.array([value]))[0] else broken
    row = JudgedRow(
        label=requirement.label,
        kind="requirement",
        quantity=requirement.quantity,
        **requirement.units(),  # pyright: ignore[reportArgumentType]
        sense=requirement.sense,
        limit=requirement.in_file(requirement.limit),
        value=requirement.in_file(value) if isfinite(value) else None,
        low=None,
        high=None,
        flights=0,
        verdict=phrase,
    )
    return row if worst is None else row.model_copy(update={"state": worst.name})


def overall(rows: list[JudgedRow]) -> str:
    """Return the verdict on all rows: the worst of theirs."""
    verdicts = {row.verdict for row in rows}
    return next((phrase for phrase in (FAIL, UNCERTAIN) if phrase in verdicts), PASS)
