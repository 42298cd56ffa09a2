"""What a results folder holds of every finalist beside front.csv, and of the search's start; older folders lack most of it."""

from pathlib import Path

import numpy as np
import pyarrow as pa

from objectives.margins.quantities import RECORDED, REPORTED
from plant.gains import GROUPS
from tuner.documents.files import Columns, read_table
from tuner.documents.parts import RecommendedGains
from tuner.documents.resolved import Resolved
from tuner.documents.results import Loop
from tuner.store.document import read_text, refuse
from tuner.store.start import Start

LIMITED = ("value", "low", "high", "difference", "difference_low", "difference_high")
LOOP_TEXTS, LOOP_LISTS = ["point", "channel", "case"], ["frequency", "real", "imag"]
# Margin quantities of each loop that a reader of a report is shown.
LOOP_MARGINS = [name for name in REPORTED if name in RECORDED]


def addresses_of(resolved: Resolved, variables: list[str], gains: RecommendedGains) -> dict[str, list[str]]:
    """Return the gains that each variable stands for, as resolved.json says, or as the names of groups do."""
    told = {entry.name: entry.addresses for entry in resolved.variables}
    found = {}
    for name in variables:
        group, _, gain = name.partition(".")
        named = told.get(name) or [f"{axis}.{gain}" for axis in GROUPS.get(group, (group,))]
        found[name] = [address for address in named if address in gains.gains]
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


def design_start(folder: Path, resolved: Resolved) -> int | None:
    """Return the candidate that the search started from as designed: the second of the first generation, behind the default."""
    file = folder / "start.json"
    if "design" not in (resolved.search.initial or []) or not file.exists():
        return None
    return None if any('"design"' in warning for warning in Start.read(file).warnings) else 1
