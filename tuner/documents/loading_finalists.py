"""What a results folder holds of every finalist beside front.csv, and of the search's start; older folders lack most of it."""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from objectives.margins.quantities import RECORDED, REPORTED
from plant.gains import GROUPS
from tuner.documents.files import Columns, Node, read_table, read_text, refuse
from tuner.documents.results import Loop

LIMITED = ("value", "low", "high", "difference", "difference_low", "difference_high")
LOOP_TEXTS, LOOP_LISTS = ["point", "channel", "case"], ["frequency", "real", "imag"]
# Margin quantities of each loop that a reader of a report is shown.
LOOP_MARGINS = [name for name in REPORTED if name in RECORDED]


def addresses_of(resolved: dict[str, Any], variables: list[str], gains: dict[str, Any]) -> dict[str, list[str]]:
    """Return the gains that each variable stands for, as resolved.json says, or as the names of groups do."""
    told = {str(entry.get("name")): entry.get("addresses") for entry in resolved.get("variables", [])}
    found = {}
    for name in variables:
        group, _, gain = name.partition(".")
        named = told.get(name) or [f"{axis}.{gain}" for axis in GROUPS.get(group, (group,))]
        found[name] = [address for address in named if address in gains]
    return found


def read_limited(file: Path) -> dict[tuple[str, str], np.ndarray]:
    """Return (point, constraint) -> the numbers of `LIMITED`; nothing where there is no such file or it has no rows."""
    if not file.exists() or len(read_text(file).splitlines()) < 2:
        return {}
    table = Columns.read(file)
    numbers = np.stack([table.numbers(name) for name in LIMITED], axis=1)
    return dict(zip(zip(table.text("point"), table.text("label"), strict=True), numbers, strict=True))


def read_loops(file: Path) -> list[Loop]:
    """Return margins and curves of every point and channel; none where there is no such file."""
    if not file.exists():
        return []
    table = read_table(file, [*LOOP_TEXTS, "stable", *LOOP_LISTS, *LOOP_MARGINS])
    try:
        frequency, real, imag = (
            np.array(table.column(name).to_pylist(), dtype=float).reshape(table.num_rows, -1) for name in LOOP_LISTS
        )
        point, channel, case = (table.column(name).cast(pa.string()).to_pylist() for name in LOOP_TEXTS)
        values = [table.column(name).cast(pa.float64()).to_pylist() for name in LOOP_MARGINS]
    except (pa.ArrowException, ValueError, TypeError) as error:
        raise refuse(file, f"a column does not hold what it should ({error})") from None
    stable = table.column("stable").to_pylist()
    return [
        Loop(
            point[k], channel[k], bool(stable[k]), {name: column[k] for name, column in zip(LOOP_MARGINS, values, strict=True)},
            case[k] or "", frequency[k], real[k] + 1j * imag[k],
        )
        for k in range(table.num_rows)
    ]  # fmt: skip


def design_start(folder: Path, resolved: dict[str, Any]) -> int | None:
    """Return the candidate that the search started from as designed: the second of the first generation, behind the default."""
    named = resolved.get("search", {}).get("initial") or []
    file = folder / "start.json"
    if "design" not in named or not file.exists():
        return None
    said = Node.read(file).get("warnings") or []
    return None if any('"design"' in str(warning) for warning in said) else 1


def read_sensitivity(file: Path) -> dict[str, Any] | None:
    """Return a sensitivity analysis, None where there is none in the folder."""
    if not file.exists():
        return None
    document = Node.read(file)
    for row in document["indices"].entries():
        for key in ("scale", "output", "variable"):
            row[key].text()
        for order in ("first", "total"):
            for part in ("value", "low", "high"):
                row[order][part].number()
    return document.value
