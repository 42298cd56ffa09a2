"""The table of margins by steady state: a row for each state, a column for each limit, the worst of each column marked."""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

from objectives.margins.quantities import QUANTITIES
from tuner.documents.margins import LimitRow, StateValue
from tuner.documents.summary import ComparedState, RequiredRow
from tuner.text.numbers import significant

WORST_MARK = "*"
"""Sign behind a value that is the worst of its column."""


class StateTable(NamedTuple):
    """limits: labels of the columns; units: theirs; states: names of the rows; values: texts by row; worst: state by column."""

    limits: list[str]
    units: list[str]
    states: list[str]
    values: list[list[str]]
    worst: list[str]

    @property
    def marked(self) -> list[list[str]]:
        """Texts by row, with a mark behind the worst value of each column."""
        return [
            [value + (WORST_MARK if state == worst else "") for value, worst in zip(row, self.worst, strict=True)]
            for state, row in zip(self.states, self.values, strict=True)
        ]


def state_table(rows: Sequence[RequiredRow | LimitRow]) -> StateTable | None:
    """Return the values of limits, in shown units, in each steady state; None where hover alone was looked at.

    Of a comparison they are those of the tuned gains.
    """
    columns = [row for row in rows if row.states]
    if not columns:
        return None
    states = [entry.state for entry in columns[0].states]
    by_limit = [[_text(entry) for entry in row.states] for row in columns]
    worst = [str(row.worst_state) for row in columns]
    values = [list(texts) for texts in zip(*by_limit, strict=True)]
    return StateTable([row.label for row in columns], [row.unit for row in columns], states, values, worst)


def tightest_margins(rows: Sequence[RequiredRow]) -> dict[str, RequiredRow]:
    """Return the margin nearest to its limit by role: "default", "tuned".

    A violated one is the nearer, the further it is beyond. Margins that were looked at in one steady state alone do not
    count. A distance is taken in shares of the limit.

    Args:
        rows: Limits in shown units.
    """
    by_state = [row for row in rows if row.states]
    roles = ("default", "tuned") if by_state else ()
    return {role: min(by_state, key=lambda row: _distance(row, getattr(row, role).value)) for role in roles}


def _distance(row: RequiredRow, value: float | None) -> float:
    """Return the distance of a value from the limit: below 0 beyond it."""
    if value is None:
        return inf if row.sense == "min" else -inf
    return (value - row.limit if row.sense == "min" else row.limit - value) / (abs(row.limit) or 1.0)


def by_quantity(rows: Sequence[LimitRow]) -> list[LimitRow]:
    """Return hard limits on margins of single loops as one row for each quantity, in the worst of the loops."""
    groups: dict[str, list[LimitRow]] = {}
    for row in rows:
        if row.hard and row.states and row.quantity in QUANTITIES:
            groups.setdefault(row.quantity, []).append(row)
    return [_worst_loop(group) for group in groups.values()]


def _worst_loop(rows: Sequence[LimitRow]) -> LimitRow:
    """Return the row of a quantity with its value in each state, and in the worst state, those of the worst loop."""
    worst = min if rows[0].sense == "min" else max
    by_state = [
        worst(entries, key=lambda entry: inf if entry.value is None else entry.value)
        for entries in zip(*[row.states for row in rows], strict=True)
    ]
    limiting = worst(by_state, key=lambda entry: inf if entry.value is None else entry.value)
    return rows[0].model_copy(update={"label": rows[0].quantity, "state": limiting.state, "states": by_state})


def _text(entry: ComparedState | StateValue) -> str:
    return "inf" if entry.value is None else significant(entry.value)
