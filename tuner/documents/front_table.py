"""fronts.csv and the sizes of the fronts: what each contender offers on the flights of the comparison."""

from pathlib import Path

import numpy as np

from tuner.documents.contest import Front, Fronts, Volume
from tuner.documents.files import Columns, Node
from tuner.documents.results import Estimate


def read_fronts(root: Node, file: Path) -> Fronts | None:
    """Return all fronts; None where nothing was tuned, or the table of the points is not there."""
    if not root.get("fronts") or not file.exists():
        return None
    node, table = root["fronts"], Columns.read(file)
    objectives = [entry.text() for entry in node["objectives"].entries()]
    fronts = [_front(table, name, objectives) for name in dict.fromkeys(table.text("contender"))]
    reference = {label: node["reference"][label].number() for label in objectives}
    return Fronts(objectives, fronts, _volumes(node), str(node.get("meaning") or ""), reference)


def _front(table: Columns, name: str, objectives: list[str]) -> Front:
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
    return Front(name, names, table.flags("recommended")[rows], values, low, high, points, lost)


def _volumes(node: Node) -> list[Volume]:
    sizes = {row["contender"].text(): int(row["points"].number()) for row in node["sizes"].entries()}
    even = [
        {row["first"].text(), row["second"].text()}
        for row in node["differences"].entries()
        if row["larger"].value is None
    ]
    volumes = []
    for row in node["hypervolume"].entries():
        name = row["contender"].text()
        share = Estimate(*[row[key].number() for key in ("value", "low", "high")])
        close = {other for pair in even if name in pair for other in pair - {name}}
        volumes.append(Volume(name, share, sizes.get(name, 0), close))
    return volumes
