"""A contest in the units that a reader sees: files keep SI units and rad, pages and figures show degrees."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tuner.documents.contest import (
    Air,
    ContenderFront,
    Fronts,
    Gain,
    ShownBestUnder,
    ShownCell,
    ShownClaim,
    ShownContest,
    ShownQuantity,
    Trace,
)
from tuner.documents.contest_loading import load_contest
from tuner.documents.inference import ShownInference, ShownSpread
from tuner.documents.results import Estimate, Fan
from tuner.text.units import in_degrees

# Names that stand for several axes in an address, the larger ones first.
GROUPS = (
    ("position", ("x", "y", "z")),
    ("attitude", ("roll", "pitch", "yaw")),
    ("horizontal", ("x", "y")),
    ("tilt", ("roll", "pitch")),
)


def load_shown(folder: Path) -> ShownContest:
    """Read a contest folder in shown units; StoreError where a file is missing or damaged."""
    return shown_contest(load_contest(folder))


def shown_contest(contest: ShownContest) -> ShownContest:
    """Return a contest with all angles in degrees."""
    factors = {entry.label: in_degrees(entry.unit).factor for entry in contest.quantities}

    def shown(estimate: Estimate, label: str) -> Estimate:
        return _scaled(estimate, factors.get(label, 1.0))

    def best(entry: ShownBestUnder) -> ShownBestUnder:
        rows = {
            name: row and row._replace(estimate=shown(row.estimate, entry.objective))
            for name, row in entry.rows.items()
        }
        return replace(entry, limit=entry.limit * factors.get(entry.subject_to, 1.0), rows=rows)

    def claimed(claim: ShownClaim) -> ShownClaim:
        return claim._replace(rows=[row._replace(difference=shown(row.difference, row.quantity)) for row in claim.rows])

    return replace(
        contest,
        quantities=[_quantity(entry) for entry in contest.quantities],
        estimates={key: shown(entry, key[1]) for key, entry in contest.estimates.items()},
        differences=[
            entry._replace(difference=shown(entry.difference, entry.quantity)) for entry in contest.differences
        ],
        claims=[claimed(claim) for claim in contest.claims],
        fronts=None if contest.fronts is None else _fronts(contest.fronts, factors),
        best_under=[best(entry) for entry in contest.best_under],
        cells=[_cell(cell) for cell in contest.cells],
        scores=[entry._replace(values=entry.values * factors.get(entry.quantity, 1.0)) for entry in contest.scores],
        fans=[_fan(fan) for fan in contest.fans],
        traces=[_trace(trace) for trace in contest.traces],
        air=[_air(entry) for entry in contest.air],
        inference=None if contest.inference is None else shown_inference(contest.inference),
    )


def shown_inference(inference: ShownInference) -> ShownInference:
    """Return an inference with printed numbers and open values in degrees."""
    cells = []
    for cell in inference.cells:
        unit, factor = in_degrees(cell.unit)
        ours, default = _spread(cell.ours, factor), _spread(cell.default, factor)
        printed, nearest = cell.printed * factor, cell.nearest * factor
        cells.append(cell._replace(unit=unit, printed=printed, nearest=nearest, ours=ours, default=default))
    return replace(inference, cells=cells)


def _scaled(entry: Estimate, factor: float) -> Estimate:
    return Estimate(*[None if part is None else part * factor for part in entry])


def _quantity(entry: ShownQuantity) -> ShownQuantity:
    unit, factor = in_degrees(entry.unit)
    return replace(entry, unit=unit, limit=None if entry.limit is None else entry.limit * factor)


def _fronts(fronts: Fronts, factors: dict[str, float]) -> Fronts:
    scale = np.array([factors.get(label, 1.0) for label in fronts.objectives])

    def scaled(front: ContenderFront) -> ContenderFront:
        return replace(front, values=front.values * scale, low=front.low * scale, high=front.high * scale)

    reference = {label: value * factors.get(label, 1.0) for label, value in fronts.reference.items()}
    return replace(fronts, fronts=[scaled(front) for front in fronts.fronts], reference=reference)


def _cell(cell: ShownCell) -> ShownCell:
    unit, factor = in_degrees(cell.unit)
    return cell._replace(
        unit=unit, printed=cell.printed * factor, mean=cell.mean * factor, central=_scaled(cell.central, factor)
    )


def _spread(spread: ShownSpread, factor: float) -> ShownSpread:
    return spread._replace(central=_scaled(spread.central, factor))


def _fan(fan: Fan) -> Fan:
    unit, factor = in_degrees(fan.unit)
    if factor == 1.0:
        return fan
    parts = {name: getattr(fan, name) * factor for name in ("reference", "low", "median", "high")}
    return replace(fan, unit=unit, **parts)


def _trace(trace: Trace) -> Trace:
    unit, factor = in_degrees(trace.unit)
    return trace._replace(unit=unit, value=trace.value * factor, reference=trace.reference * factor)


def _air(entry: Air) -> Air:
    unit, factor = in_degrees(entry.unit)
    return entry._replace(unit=unit, value=entry.value * factor)


def joined(gains: list[Gain]) -> list[Gain]:
    """Return gains in their order, those of a whole group of axes as one where all are the same, as in most studies."""
    told = list(gains)
    for group, axes in GROUPS:
        for name in dict.fromkeys(gain.address.partition(".")[2] for gain in gains):
            members = [gain for gain in told if gain.address in [f"{axis}.{name}" for axis in axes]]
            if len(members) == len(axes) and len({gain.value for gain in members}) == 1:
                told[told.index(members[0])] = members[0]._replace(address=f"{group}.{name}")
                told = [gain for gain in told if gain not in members]
    return told
