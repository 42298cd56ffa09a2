"""Front of an earlier run, read for another study."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np

from plant.errors import InputError
from plant.input_files import MAX_TABLE_BYTES, given_content, given_text
from plant.texts import PlainTable, json_table
from tuner.text.product import current_format

# Files of a run's gains, the second one of a run that found nothing feasible.
GAINS_FILES = ("gains.json", "infeasible.json")
FRONT, RESOLVED = "front.csv", "resolved.json"
GIVE_FINISHED = "give the folder of a finished tuning run, or a gains.json"
DEFAULT = "default"
VARIABLES_FORMAT = "gainproof-variables"


@dataclass(frozen=True)
class FrontTable:
    """Points of a front.

    Attributes:
        addresses: Gains that each column of the rows represents.
        rows: Values (n, d) of the searched gains.
        values: Held-out objectives (n, m).
        baseline: Those (m,) of the default.
    """

    addresses: tuple[tuple[str, ...], ...]
    rows: np.ndarray
    values: np.ndarray
    baseline: np.ndarray

    def gains(self, row: int) -> dict[str, float]:
        """Return the searched gains of a point by address."""
        return {
            address: float(value)
            for addresses, value in zip(self.addresses, self.rows[row], strict=True)
            for address in addresses
        }


def gains_file_of(path: Path) -> Path:
    """Return the gains file of a results folder, or a file itself; InputError where the folder has none."""
    if not path.is_dir():
        return path
    for name in GAINS_FILES:
        if (path / name).is_file():
            return path / name
    raise InputError(f"holds no {GAINS_FILES[0]}: it is no folder of a finished tuning run; {GIVE_FINISHED}", file=path)


def read_front(folder: Path) -> FrontTable:
    """Return the front of a results folder; InputError where it is missing, empty or damaged."""
    file = folder / FRONT
    text = given_content(file, GIVE_FINISHED, MAX_TABLE_BYTES).decode(errors="replace")
    header, *cells = [row for row in csv.reader(StringIO(text)) if row] or [[]]
    gains = [name for name in header if name.startswith("gain:")]
    held_out = [name for name in header if name.startswith("held_out:")]
    if "role" not in header or not gains or not held_out or any(len(row) != len(header) for row in cells):
        raise InputError(
            f"is damaged, or of another program: its columns are not those of a front; {GIVE_FINISHED}", file=file
        )
    role = header.index("role")
    front = [row for row in cells if row[role] != DEFAULT]
    default = [row for row in cells if row[role] == DEFAULT]
    if not front or not default:
        raise InputError(f"holds no point besides the default; {GIVE_FINISHED}", file=file)
    addresses = _addresses(folder / RESOLVED)
    return FrontTable(
        addresses=tuple(addresses.get(name.removeprefix("gain:"), ()) for name in gains),
        rows=_numbers(file, header, front, gains),
        values=_numbers(file, header, front, held_out),
        baseline=_numbers(file, header, default, held_out)[0],
    )


def _numbers(file: Path, header: list[str], rows: list[list[str]], names: Sequence[str]) -> np.ndarray:
    """Return columns (rows, names) as finite numbers."""
    columns = [header.index(name) for name in names]
    try:
        numbers = np.array([[float(row[column]) for column in columns] for row in rows])
    except ValueError as error:
        raise InputError(f"is damaged: {error}; {GIVE_FINISHED}", file=file) from None
    if not np.isfinite(numbers).all():
        raise InputError(f"is damaged: not every gain and objective is a finite number; {GIVE_FINISHED}", file=file)
    return numbers


def _addresses(file: Path) -> dict[str, tuple[str, ...]]:
    """Return the gains that each variable of a run represents."""
    document = json_table(given_text(file, GIVE_FINISHED), file)
    variables = document.get("variables")
    entries: list[PlainTable] = (
        [entry for entry in variables if isinstance(entry, dict)] if isinstance(variables, list) else []
    )
    by_name = {str(entry.get("name")): entry.get("addresses") for entry in entries}
    if not by_name or not all(isinstance(addresses, list) for addresses in by_name.values()):
        raise InputError(f"is damaged: it lists no searched gains; {GIVE_FINISHED}", file=file, key="variables")
    return {name: tuple(map(str, addresses)) for name, addresses in by_name.items() if isinstance(addresses, list)}


def read_variables(file: Path) -> dict[str, float]:
    """Return the values of a gains.json of trials by variable; InputError where it is none."""
    document = json_table(given_text(file, GIVE_FINISHED), file)
    if current_format(document.get("format")) != VARIABLES_FORMAT:
        raise InputError("holds no values of trials; give that of a run of trials", file=file, key="format")
    gains = document.get("gains")
    entries = gains.items() if isinstance(gains, dict) else ()
    given = {name: entry.get("value") for name, entry in entries if isinstance(entry, dict)}
    values = {name: float(value) for name, value in given.items() if isinstance(value, int | float)}
    if not values or len(values) < len(given):
        raise InputError(f"is damaged: it holds no values; {GIVE_FINISHED}", file=file, key="gains")
    return values
