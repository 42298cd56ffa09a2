"""The Parquet files of a contest: scores, fans, flight 0 and its air. A file that is not there holds nothing."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tuner.documents.contest import Air, Scores, Trace
from tuner.documents.files import numbers, read_table, refuse
from tuner.documents.loading import codes_of
from tuner.documents.results import Fan

Group = tuple[list[str], np.ndarray]
"""The names that the rows of a group share, and their numbers (rows, columns)."""


def read_scores(file: Path) -> list[Scores]:
    """Return the values of every contender in every quantity, over all scenarios that count for it."""
    found = []
    for (contender, quantity), values in _groups(file, ["contender", "quantity"], ["value"]):
        if not np.isfinite(values).all():
            raise refuse(file, "the column 'value' holds something that is no finite number")
        found.append(Scores(contender, quantity, np.sort(values[:, 0])))
    return found


def read_fans(file: Path) -> list[Fan]:
    """Return the fans of every contender, scenario and signal."""
    names, columns = ["point", "scenario", "signal", "unit"], ["time", "reference", "low", "median", "high"]
    return [
        Fan(point, scenario, signal, _shown(unit), *values.T)
        for (point, scenario, signal, unit), values in _groups(file, names, columns)
    ]


def read_traces(file: Path) -> list[Trace]:
    """Return every signal of the single flights."""
    names, columns = ["contender", "scenario", "signal", "unit"], ["time", "value", "reference"]
    return [
        Trace(contender, scenario, signal, _shown(unit), *values.T)
        for (contender, scenario, signal, unit), values in _groups(file, names, columns)
    ]


def read_air(file: Path) -> list[Air]:
    """Return the components of the air of the single flights."""
    return [
        Air(scenario, signal, _shown(unit), *values.T)
        for (scenario, signal, unit), values in _groups(file, ["scenario", "signal", "unit"], ["time", "value"])
    ]


def _groups(file: Path, names: list[str], columns: list[str]) -> Iterator[Group]:
    """Yield the rows with the same names, in order of first appearance; rows of a group need not be neighbours."""
    if not file.exists():
        return
    table = read_table(file, names + columns)
    if table.num_rows == 0:
        return
    codes = [codes_of(table.column(name), file) for name in names]
    group = np.ravel_multi_index([code for code, _ in codes], [len(known) for _, known in codes])
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    values = numbers(table, columns, file)
    rows = sorted(np.split(order, starts[1:]), key=lambda part: part[0])
    for part in rows:
        yield [known[int(code[part[0]])] for code, known in codes], values[part]


def _shown(unit: str) -> str:
    return "" if unit == "1" else unit
