"""Numbers of every finalist: the one table that front.csv, its reader, the page, `tuner show` and the Python API go by."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np

from tuner.documents.tables import Columns


class FinalistColumn(NamedTuple):
    """A column of front.csv.

    form: how a cell is shown; heading: over its column in the page's table of finalists, "" where it has none of its own;
    meaning: what the number is, told next to the heading; missing: the value in folders that lack it, None for no value.
    """

    name: str
    form: Literal["flag", "count", "share", "number"]
    heading: str = ""
    meaning: str = ""
    missing: int | None = None

    @property
    def about(self) -> dict[str, str]:
        """The column as the page's table needs it."""
        return {"name": self.name, "form": self.form, "heading": self.heading, "meaning": self.meaning}

    def read(self, table: Columns) -> np.ndarray | None:
        """Return the values (finalists,), None where the folder holds none."""
        if self.form == "flag":
            return table.flags(self.name)
        if self.name not in table.columns:
            return None if self.missing is None else np.full(table.rows, self.missing)
        return table.numbers(self.name).astype(int if self.form == "count" else float)

    def cell(self, columns: Mapping[str, np.ndarray], row: int) -> bool | int | float | None:
        """Return the value of a finalist among columns that were read, None where there is none."""
        value = columns[self.name][row].item() if self.name in columns else None
        return None if value is None or not np.isfinite(value) else value


FINALIST_COLUMNS = (
    FinalistColumn("non_dominated", "flag"),
    FinalistColumn(
        "probability",
        "share",
        "Non-dominated",
        "bootstrap probability, over held-out scenarios, that the point is non-dominated among all finalists",
    ),
    FinalistColumn("feasible", "flag"),
    FinalistColumn("lost", "count", missing=0),
    FinalistColumn(
        "flights",
        "count",
        "Simulations",
        "held-out simulations made: fewer where the rank was already decided, so the intervals are wider",
    ),
)
"""Attributes of `Finalists`, which holds the values; a number more is a row more."""
