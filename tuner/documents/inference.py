"""What a report knows of an inference: which open values would reproduce printed numbers. SI units, angles in rad."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from tuner.documents.files import Node
from tuner.documents.results import Estimate

Pair = tuple[float, float]
REPRODUCED = (("here", "inside"), ("near", "consistent"), ("elsewhere", "reproducible"))
"""By which settings a printed number lies inside, the first whose key holds: the inferred one, one that fits about as well,
any that was tried; else "nowhere".
"""


class Unknown(NamedTuple):
    """A value that was searched. near: what fits about as well; again: 68 % of what other draws of the flights would give.

    verdict: "told", "loosely" or "not" told by the printed numbers; at_end: an end of the range is among what fits.
    """

    name: str
    unit: str
    addresses: list[str]
    low: float
    high: float
    log: bool
    default: float
    inferred: float
    near: Pair
    again: Pair
    at_end: bool
    verdict: str


class Spread(NamedTuple):
    """Our flights under one setting: median with central 95 %, percentile of the printed number, whether it is inside."""

    central: Estimate
    percentile: float
    inside: bool


class Cell(NamedTuple):
    """A printed number against our flights; by: see `REPRODUCED`; nearest: the median nearest to it of any setting."""

    contender: str
    metric: str
    scenario: str
    unit: str
    printed: float
    ours: Spread
    default: Spread
    by: str
    nearest: float


class Ratio(NamedTuple):
    """A printed ratio of two contenders, second to first, against that of our flights in the same air."""

    first: str
    second: str
    metric: str
    scenario: str
    printed: float
    ours: Spread
    by: str
    nearest: float


class Misfit(NamedTuple):
    """How far a setting is from the printed numbers: root mean square of ln(ours / printed) by kind; how many are inside."""

    name: str
    search: dict[str, float]
    held_out: dict[str, float]
    inside: int


@dataclass(frozen=True)
class Inference:
    """An inference. document: inference.json; misfits: of the default, the inferred setting and the front."""

    document: dict[str, Any]
    contenders: list[str]
    words: list[str]
    unknowns: list[Unknown]
    cells: list[Cell]
    ratios: list[Ratio]
    misfits: list[Misfit]
    kinds: list[str]


def load_inference(file: Path) -> Inference:
    """Read inference.json; StoreError names what is missing or wrong."""
    root = Node.read(file)
    kinds = [*[row["metric"].text() for row in root["kinds"].entries()], "all"]
    named = [
        ("default", root["misfit"]["default"]),
        (f"inferred, {root['inferred'].text()}", root["misfit"]["inferred"]),
    ]
    named += [(row["candidate"].text(), row) for row in root["front"].entries()]
    for key in ("tried", "flights", "held_out", "near"):
        root["settings"][key].number()
    for key in ("flights", "wall_seconds", "seed"):
        root[key].number()
    root["title"].text()
    return Inference(
        document=root.value,
        contenders=[entry.text() for entry in root["contenders"].entries()],
        words=[entry.text() for entry in root["words"].entries()],
        unknowns=[_unknown(row) for row in root["unknowns"].entries()],
        cells=[_cell(row) for row in root["cells"].entries()],
        ratios=[_ratio(row) for row in root["ratios"].entries()],
        misfits=[_misfit(name, row, kinds) for name, row in named],
        kinds=kinds,
    )


def _unknown(row: Node) -> Unknown:
    low, high, default, inferred = (row[key].number() for key in ("low", "high", "default", "inferred"))
    near, again = ((row[a].number(), row[b].number()) for a, b in (("near_low", "near_high"), ("low68", "high68")))
    addresses = [entry.text() for entry in row["set"].entries()]
    log, at_end = row["scale"].text() == "log", bool(row["at_end"].value)
    names = row["name"].text(), _unit(row)
    return Unknown(*names, addresses, low, high, log, default, inferred, near, again, at_end, row["verdict"].text())


def _cell(row: Node) -> Cell:
    printed = row["published"].number()
    return Cell(
        contender=row["contender"].text(),
        metric=row["metric"].text(),
        scenario=row["scenario"].text(),
        unit=_unit(row),
        printed=printed,
        ours=_spread(row["ours"]),
        default=_spread(row["default"]),
        by=_by(row),
        nearest=row["best_ratio"].number() * printed,
    )


def _ratio(row: Node) -> Ratio:
    first, second, metric, scenario = (row[key].text() for key in ("first", "second", "metric", "scenario"))
    printed, nearest = row["published"].number(), row["nearest"].number()
    return Ratio(first, second, metric, scenario, printed, _spread(row["ours"]), _by(row), nearest)


def _by(row: Node) -> str:
    return next((word for word, key in REPRODUCED if row.get(key)), "nowhere")


def _spread(row: Node) -> Spread:
    central = Estimate(*[row[key].number() for key in ("median", "low95", "high95")])
    return Spread(central, row["percentile"].number(), bool(row["inside"].value))


def _misfit(name: str, row: Node, kinds: list[str]) -> Misfit:
    search, held_out = ({kind: row[part][kind].number() for kind in kinds} for part in ("search", "held_out"))
    return Misfit(name, search, held_out, int(row["inside"].number()))


def _unit(row: Node) -> str:
    unit = row["unit"].text()
    return "" if unit == "1" else unit
