"""Tables that are written: columns by name, each a sequence of one length, or a single value for all rows.

A run writes its tables without pandas, which takes 0.3 s of processor time to import; as .npz by `tuner.store.npz`.
"""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

Columns = dict[str, Any]
"""Columns by name: arrays, lists, or one value for all rows; a number may be missing (None or NaN), a text not."""


@dataclass(frozen=True)
class Coded:
    """Texts of a column as codes (rows,), integers, into names; categorical: for pandas, too."""

    codes: np.ndarray
    names: list[str]
    categorical: bool = True

    def __len__(self) -> int:
        return len(self.codes)

    def texts(self) -> list[str]:
        """Return the text of each row."""
        return [self.names[code] for code in self.codes.tolist()]


def in_codes(texts: Sequence[str] | np.ndarray, categorical: bool = True) -> Coded:
    """Return texts as codes of the distinct texts, in alphabetical order."""
    listed = texts.tolist() if isinstance(texts, np.ndarray) else texts
    names = sorted(set(listed))
    code = {text: i for i, text in enumerate(names)}
    codes = np.fromiter(map(code.__getitem__, listed), np.min_scalar_type(-len(names)), len(listed))
    return Coded(codes, names, categorical)


def columns_of(rows: Sequence[Mapping[str, Any]]) -> Columns:
    """Return rows as columns, in order of first appearance, None where missing."""
    names = dict.fromkeys(chain.from_iterable(rows))
    return {name: [row.get(name) for row in rows] for name in names}


def filled(columns: Mapping[str, Any]) -> Columns:
    """Return columns with every single value repeated for each row; of single values alone, one row."""
    many = next((len(values) for values in columns.values() if not is_single(values)), 1)
    return {name: repeated(values, many) if is_single(values) else values for name, values in columns.items()}


def is_single(values: Any) -> bool:
    """Return True for a column given as one value for all rows."""
    return isinstance(values, str) or not hasattr(values, "__len__")


def repeated(value: Any, count: int) -> np.ndarray:
    """Return a value so many times; of a text, references to the one."""
    return np.full(count, value, dtype=object if isinstance(value, str) else None)


def stacked(tables: Iterable[Mapping[str, Any]]) -> Columns:
    """Return tables of the same columns one below the other as one."""
    parts = [filled(table) for table in tables]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def csv_text(columns: Mapping[str, Any]) -> str:
    """Return a table as CSV; numbers with all their digits, nothing where one is missing."""
    table, text = filled(columns), io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table)
    writer.writerows(zip(*[map(cell, values) for values in table.values()], strict=True))
    return text.getvalue()


def cell(value: Any) -> Any:
    """Return a value as it stands in a CSV file."""
    if value is None or value != value:
        return ""
    return f"{value:.17g}" if isinstance(value, float | np.floating) else value
