"""What a report knows of an inference: which open values would reproduce printed numbers. SI units, angles in rad."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from tuner.documents.inference_document import CellRow, InferenceDocument, RatioRow, SpreadPart, UnknownRow
from tuner.documents.parts import Estimate

Pair = tuple[float, float]


class ShownUnknown(NamedTuple):
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


class ShownSpread(NamedTuple):
    """Our flights under one setting: median with central 95 %, percentile of the printed number, whether it is inside."""

    central: Estimate
    percentile: float
    inside: bool


class ReproducedCell(NamedTuple):
    """A printed number against our flights; by: setting by which it is inside; nearest: the nearest median of any setting."""

    contender: str
    metric: str
    scenario: str
    unit: str
    printed: float
    ours: ShownSpread
    default: ShownSpread
    by: str
    nearest: float


class ReproducedRatio(NamedTuple):
    """A printed ratio of two contenders, second to first, against that of our flights in the same air."""

    first: str
    second: str
    metric: str
    scenario: str
    printed: float
    ours: ShownSpread
    by: str
    nearest: float


class Misfit(NamedTuple):
    """How far a setting is from the printed numbers: root mean square of ln(ours / printed) by kind; how many are inside."""

    name: str
    search: dict[str, float]
    held_out: dict[str, float]
    inside: int


@dataclass(frozen=True)
class ShownInference:
    """An inference. document: inference.json; misfits: of the default, the inferred setting and the front."""

    document: InferenceDocument
    contenders: list[str]
    words: list[str]
    unknowns: list[ShownUnknown]
    cells: list[ReproducedCell]
    ratios: list[ReproducedRatio]
    misfits: list[Misfit]
    kinds: list[str]


def load_inference(file: Path) -> ShownInference:
    """Read inference.json; StoreError names what is missing or wrong."""
    document = InferenceDocument.read(file)
    return ShownInference(
        document=document,
        contenders=document.contenders,
        words=document.words,
        unknowns=[_unknown(row) for row in document.unknowns],
        cells=[_cell(row) for row in document.cells],
        ratios=[_ratio(row) for row in document.ratios],
        misfits=[Misfit(name, row.search, row.held_out, row.inside) for name, row in document.misfits],
        kinds=document.misfit_kinds,
    )


def _unknown(row: UnknownRow) -> ShownUnknown:
    return ShownUnknown(
        row.name, _shown(row.unit), row.addresses, row.low, row.high, row.scale == "log", row.default, row.inferred,
        row.near, row.again, row.at_end, row.verdict,
    )  # fmt: skip


def _cell(row: CellRow) -> ReproducedCell:
    return ReproducedCell(
        contender=row.contender,
        metric=row.metric,
        scenario=row.scenario,
        unit=_shown(row.unit),
        printed=row.published,
        ours=_spread(row.ours),
        default=_spread(row.default),
        by=row.by,
        nearest=row.nearest,
    )


def _ratio(row: RatioRow) -> ReproducedRatio:
    return ReproducedRatio(
        row.first, row.second, row.metric, row.scenario, row.published, _spread(row.ours), row.by, row.nearest
    )  # fmt: skip


def _spread(row: SpreadPart) -> ShownSpread:
    return ShownSpread(row.central, row.percentile, row.inside)


def _shown(unit: str) -> str:
    return "" if unit == "1" else unit
