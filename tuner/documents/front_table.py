"""fronts.csv and the sizes of the fronts: what each contender offers on the flights of the comparison."""

from pathlib import Path

import numpy as np

from tuner.documents.contest import ContenderFront, Fronts, Volume
from tuner.documents.contest_document import FrontsPart
from tuner.documents.files import Columns
from tuner.documents.parts import Estimate


def read_fronts(found: FrontsPart | None, file: Path) -> Fronts | None:
    """Return all fronts; None where nothing was tuned, or the table of the points is not there."""
    if found is None or not file.exists():
        return None
    table = Columns.read(file)
    fronts = [_front(table, name, found.objectives) for name in dict.fromkeys(table.text("contender"))]
    return Fronts(found.objectives, fronts, _volumes(found), found.meaning, found.reference)


def _front(table: Columns, name: str, objectives: list[str]) -> ContenderFront:
    rows = [i for i, entry in enumerate(table.text("contender")) if entry == name]
    values, low, high = (
        np.stack([table.numbers(f"{kind}:{label}")[rows] for label in objectives], axis=1)
        for kind in ("value", "low", "high")
    )
    gains = {key.removeprefix("gain:"): table.numbers(key)[rows] for key in table.columns if key.startswith("gain:")}
    # The laws of other contenders have other gains: their columns are empty here.
    own = {address: column for address, column in gains.items() if np.isfinite(column).all()}
    points = [{address: float(column[i]) for address, column in own.items()} for i in range(len(rows))]
    names = [table.text("point")[i] for i in rows]
    lost = table.numbers("lost")[rows].astype(int)
    return ContenderFront(name, names, table.flags("recommended")[rows], values, low, high, points, lost)


def _volumes(found: FrontsPart) -> list[Volume]:
    sizes = {row.contender: row.points for row in found.sizes}
    even = [{row.first, row.second} for row in found.differences if row.larger is None]
    volumes = []
    for row in found.hypervolume:
        close = {other for pair in even if row.contender in pair for other in pair - {row.contender}}
        share = Estimate(row.value, row.low, row.high)
        volumes.append(Volume(row.contender, share, sizes.get(row.contender, 0), close))
    return volumes
