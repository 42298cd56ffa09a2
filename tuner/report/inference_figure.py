"""The figure of an inference: our flights over each published cell, and how well each unknown is told."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from objectives.decisions import Variable
from tuner.documents.inference_document import CellRow, InferenceDocument, UnknownRow
from tuner.report.charts.chart import Axis, Mark, Panel, Points, Rule, row_axis, segments, span_of, value_axis
from tuner.report.charts.files import save
from tuner.report.charts.look import DEFAULT, FRONT, TUNED, Look
from tuner.report.charts.paper import Figure, figure_of, style
from tuner.study.inference import LEAST_RATIO
from tuner.text.numbers import significant

# Height of a row of cells, rows of which an unknown takes two, and what surrounds the panels [in].
LINE, AROUND = 0.19, 0.9
EXACT = Look("ink", width=1.4)
# Spans above this factor are drawn on a logarithmic axis: ratios always are.
LOG_FACTOR = 1.0


def write_inference_figures(folder: Path) -> list[Path]:
    """Write figures/inference.png and .pdf of a results folder."""
    with style():
        figure = inference_figure(InferenceDocument.read(folder / "inference.json"))
        return save(figure, folder, "figures/inference")


def inference_figure(document: InferenceDocument) -> Figure:
    """Return cells at the left, unknowns at the right."""
    lines = max(len(document.cells), 2 * len(document.unknowns))
    panels = [cells_panel(document.cells), unknowns_panel(document.unknowns, document.settings.near)]
    return figure_of(panels, 2, AROUND + LINE * lines)


def cells_panel(cells: Sequence[CellRow]) -> Panel:
    """Return median, central 68 % and 95 % of ours over published, default above inferred; a star: under no setting inside."""
    marks: list[Mark] = [Rule(look=EXACT, axis="x", value=1.0)]
    all_ratios = []
    for look, name, offset in ((DEFAULT, "default", 0.2), (TUNED, "inferred", -0.2)):
        rows = [cell.ours if name == "inferred" else cell.default for cell in cells]
        numbers = np.array([[row.low95, row.low68, row.median, row.high68, row.high95] for row in rows])
        ratios = np.maximum(numbers / np.array([[cell.published] for cell in cells]), LEAST_RATIO)
        low95, low68, median, high68, high95 = ratios.T
        y, solid = offset - np.arange(len(cells)), look._replace(dash=(), width=4.0)
        words = f"{name}: median, 68 and 95 % of flights"
        marks.append(segments(low68, high68, y, solid))
        marks.append(Points(name=words, look=look, x=median, y=y, x_ends=(low95, high95)))
        all_ratios.append(ratios)
    x = value_axis(
        f"ours / published, from {LEAST_RATIO:g} on\n(*: under no setting inside)", "", span_of(all_ratios, LOG_FACTOR)
    )
    names = [f"{cell.contender}  {cell.metric}{'' if cell.reproducible else ' *'}" for cell in cells]
    return Panel("", "", x, row_axis(names), marks, rows=True)


def unknowns_panel(unknowns: Sequence[UnknownRow], near: float) -> Panel:
    """Return for each unknown, on the range searched, what fits as well and what a table of one draw leaves open."""
    y = -np.arange(float(len(unknowns)))
    marks: list[Mark] = []
    for look, offset, ends in ((TUNED, 0.12, ("near_low", "near_high")), (FRONT, -0.12, ("low68", "high68"))):
        low, high = (np.array([_unit(row, getattr(row, end)) for row in unknowns]) for end in ends)
        marks.append(segments(low, high, y + offset, look._replace(width=4.0)))
    for look, key in ((DEFAULT, "default"), (TUNED, "inferred")):
        marks.append(Points(look=look, x=np.array([_unit(row, getattr(row, key)) for row in unknowns]), y=y))
    title = (
        f"range searched. Blue: within {100 * near:g} % of the least\nmisfit. Green: what one draw leaves open (68 %)"
    )
    ranges = [f"{significant(row.low, 3)}–{significant(row.high, 3)} {row.unit}, {row.scale}" for row in unknowns]
    names = [
        f"{row.name}: {significant(row.inferred, 3)}\n({searched})"
        for row, searched in zip(unknowns, ranges, strict=True)
    ]
    x = Axis(title, -0.03, 1.03, ticks=((0.0, "low"), (1.0, "high")))
    return Panel("", "", x, row_axis(names), marks, rows=True)


def _unit(row: UnknownRow, value: float) -> float:
    """Return the place of a value in the range of its unknown, 0 to 1 on its scale."""
    return Variable(row.name, (), row.low, row.high, row.scale).unit(value)
