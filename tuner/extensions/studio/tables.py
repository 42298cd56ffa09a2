"""Tables of the page as texts: objectives, limits, margins of each loop, and settings against each other."""

from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from objectives.margins.quantities import QUANTITIES, REPORTED
from objectives.problem import Evaluation
from objectives.risk import minimum_samples
from tuner.analysis.held_out import compare, compare_known, required_row
from tuner.documents.margins import MarginsDocument
from tuner.documents.parts import Estimate, on_page, row_in_degrees
from tuner.documents.summary import ComparedRow, RequiredRow
from tuner.documents.tuning import SHOWN
from tuner.documents.verdicts import BROKEN, NOT_CERTAIN, signed_verdict, verdict_on_limit
from tuner.extensions.studio.flights import STAGES, Flights, rows_of, search_values
from tuner.extensions.studio.session import Session, Setting
from tuner.report.labels import definition_text, plain_label, plain_margin, time_unit
from tuner.report.verdict_text import ALL_LIMITS
from tuner.study.plant_study import PlantStudy
from tuner.text.numbers import MISSING, estimate, plus, significant
from tuner.text.sentences import bound_text
from tuner.text.units import plain

Cell = list[str]
"""Number and interval, or number alone."""
Row = dict[str, Any]


def judged(session: Session, flights: Flights, settings: Sequence[Setting], count: int) -> list[Row]:
    """Return a row for each objective and limit: values of all settings, and the first against every other one.

    Args:
        session: The opened study.
        flights: Its flights.
        settings: The setting at hand, then those that it is compared with.
        count: Flights of each scenario.
    """
    rows = np.array([setting.row for setting in settings])
    evaluation = flights.evaluate(rows, count)
    pairs = [_pair(session, flights, evaluation, rows, i, count) for i in range(1, len(settings))]
    return [_row(session, [pair[k] for pair in pairs]) for k in range(len(pairs[0]))]


def _pair(
    session: Session, flights: Flights, evaluation: Evaluation, rows: np.ndarray, other: int, count: int
) -> list[ComparedRow | RequiredRow]:
    """Return the comparison of the setting at hand with another."""
    problem, study = flights.problem, session.study
    both = rows_of(evaluation, (other, 0))
    flown = compare(problem, both, study.seed, study.table.relevant, flights.costs(count))
    if count > STAGES[0]:
        return [*flown, *compare_known(problem, rows[[other, 0]])]
    values = zip(problem.requirements, *search_values(problem, rows[[other, 0]]).tolist(), strict=True)
    return [*flown, *[required_row(requirement, first, second) for requirement, first, second in values]]


def _row(session: Session, pairs: Sequence[ComparedRow | RequiredRow]) -> Row:
    shown = [on_page(row, *SHOWN) if row.kind == "requirement" else row_in_degrees(row, *SHOWN) for row in pairs]
    first = shown[0]
    return {
        "label": first.label,
        "name": _named(session, first),
        "tip": definition_text(first).replace("`", ""),
        "unit": plain(first.unit),
        "kind": first.kind,
        "limit": "" if first.limit is None else bound_text(first.limit, first.sense),
        "verdict": _words(first, first.limit is not None),
        "here": _cell(first.tuned),
        "others": [_cell(row.default) for row in shown],
        "changes": [_cell(row.difference, signed=True) for row in shown],
        # Differences of limited quantities have no verdict: the limit has one.
        "words": [_words(row, row.limit is None) for row in shown],
        "broken": [_is_broken(row) for row in shown],
        "state": getattr(first, "tuned_state", None) or "",
        "evidence": list(getattr(first, "evidence", ("", "")))[1],
        "value": first.tuned.value,
    }


def _named(session: Session, row: ComparedRow | RequiredRow) -> str:
    if isinstance(row, RequiredRow):
        return plain_margin(row.label)
    scenario = row.scenario if len(session.study.scenarios) > 1 else None
    channels = None if session.has_rotors else set(cast("PlantStudy", session.study).system.plan.names)
    return plain_label(row.label, row.metric, scenario, channels, short=True)


def _words(row: ComparedRow | RequiredRow, is_shown: bool) -> dict[str, str]:
    """Return a verdict as class and text, empty if not shown."""
    if not is_shown:
        return {"word": "", "text": ""}
    return {"word": row.verdict.replace(" ", "-"), "text": signed_verdict(row.verdict)}


def _is_broken(row: ComparedRow | RequiredRow) -> bool:
    return row.limit is not None and verdict_on_limit(row.default.value, row.limit, row.sense) == BROKEN


def _cell(entry: Estimate, signed: bool = False) -> Cell:
    if entry.low is None:
        return [MISSING if entry.value is None else plus(entry.value, signed) + significant(entry.value)]
    return list(estimate(*entry.parts, signed))


def summary(rows: Sequence[Row]) -> str:
    """Return one sentence on limits and objectives of the setting at hand."""
    limits = [row for row in rows if row["limit"]]
    broken = [row["name"] for row in limits if row["verdict"]["word"] == BROKEN]
    open_ = [row["name"] for row in limits if row["verdict"]["word"] == NOT_CERTAIN.replace(" ", "-")]
    if broken:
        count = "the limit" if len(limits) == 1 else f"{len(broken)} of {len(limits)} limits"
        return f"Violates {count}: {', '.join(broken)}."
    if open_:
        return f"Violates no limit; not certain yet: {', '.join(open_)}."
    if not limits:
        return "The study has no limits."
    return f"Satisfies {ALL_LIMITS.get(len(limits), f'all {len(limits)} limits')}."


def precision_note(session: Session, flights: Flights, count: int) -> str:
    """Return sentences on numbers that more flights or a rest settle."""
    few = [
        entry.label
        for entry in session.study.objectives
        if count * (1 if entry.scenario else len(session.study.scenarios)) < minimum_samples(entry.risk)
    ]
    notes = [f"Few flights in the tail yet: {', '.join(few)}."] * bool(few)
    if count <= STAGES[0] and any(screen.complete for screen in flights.problem.screens):
        notes.append("Limits on margins in all steady states follow.")
    return " ".join(notes)


def loop_table(document: MarginsDocument) -> Row:
    """Return the margins of each loop in shown units."""
    channels, rows = document.channels, []
    for name in REPORTED:
        quantity = QUANTITIES[name]
        values = [channel.quantities[name].value for channel in channels]
        unit, size = time_unit(name, values)
        cells = [
            MISSING
            if not channel.stable
            else quantity.infinite_text("∞")
            if value is None
            else significant(float(quantity.shown(value)) / size, 4)
            for channel, value in zip(channels, values, strict=True)
        ]
        rows.append({"name": quantity.label, "unit": plain("" if unit == "1" else unit), "cells": cells})
    stable = {"name": "stable", "unit": "", "cells": ["yes" if channel.stable else "NO" for channel in channels]}
    return {"channels": [channel.channel for channel in channels], "rows": [stable, *rows]}
