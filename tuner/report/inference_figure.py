"""The figure of an inference: our flights over each published cell, and how well each unknown is told."""

import json
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plant.input_files import read_input_text
from tuner.report.charts.look import DEFAULT, INKS, TUNED
from tuner.report.charts.paper import grid, legend_above, save, style
from tuner.study.inference import LEAST_RATIO
from tuner.text.numbers import significant

Document = dict[str, Any]
# Height of a line of the left panel and of what surrounds the panels [in].
LINE, AROUND = 0.19, 0.9
ROLES = (("default", "default", 0.2), ("tuned", "inferred", -0.2))
"""Look, name and offset of the two settings."""


def write_inference_figures(folder: Path) -> list[Path]:
    """Write figures/inference.png and .pdf of a results folder."""
    document = json.loads(read_input_text(folder / "inference.json"))
    with style():
        return save(inference_figure(document), folder, "figures/inference")


def inference_figure(document: Document) -> Figure:
    """Return cells at the left, unknowns at the right."""
    lines = max(len(document["cells"]), 2 * len(document["unknowns"]))
    figure, (cells, unknowns) = grid(2, 2, AROUND + LINE * lines)
    draw_cells(cells, document)
    draw_unknowns(unknowns, document)
    legend_above(figure, cells)
    return figure


def draw_cells(ax: Axes, document: Document) -> None:
    """Draw central 95 % and 68 % and median of ours over published, default above inferred; bold: never inside."""
    rows = document["cells"]
    for look, name, offset in ROLES:
        colour = INKS[look]
        for i, row in enumerate(rows):
            ours, y = row["ours" if name == "inferred" else "default"], i - offset
            first = i == 0
            for low, high, width in (("low95", "high95", 0.8), ("low68", "high68", 2.6)):
                ends = [max(ours[key] / row["published"], LEAST_RATIO) for key in (low, high)]
                ax.plot(ends, [y, y], color=colour, linewidth=width, solid_capstyle="butt")
            middle = max(ours["median"] / row["published"], LEAST_RATIO)
            label = f"{name}: median, 68 and 95 % of flights" if first else None
            ax.plot(
                middle, y, (DEFAULT if look == "default" else TUNED).marker, color=colour, markersize=3.5, label=label
            )
    ax.axvline(1.0, color=INKS["ink"], linewidth=0.9)
    ax.set_xscale("log")
    ax.set_yticks(range(len(rows)), [f"{row['contender']}  {row['metric']}" for row in rows])
    for text, row in zip(ax.get_yticklabels(), rows, strict=True):
        text.set_fontweight("normal" if row["reproducible"] else "bold")
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.set_xlabel(f"ours / published, from {LEAST_RATIO:g} on\n(bold: under no setting inside)")


def draw_unknowns(ax: Axes, document: Document) -> None:
    """Draw for each unknown, on the range searched, what fits as well and what a table of one draw leaves open."""
    rows = document["unknowns"]
    for i, row in enumerate(rows):
        near, again = (
            [_unit(row, row[key]) for key in keys] for keys in (("near_low", "near_high"), ("low68", "high68"))
        )
        ax.plot(near, [i - 0.12] * 2, color=INKS["tuned"], linewidth=2.6, solid_capstyle="butt")
        ax.plot(again, [i + 0.12] * 2, color=INKS["front"], linewidth=2.6, solid_capstyle="butt")
        for look, key in (("default", "default"), ("tuned", "inferred")):
            ax.plot(
                _unit(row, row[key]),
                i,
                (DEFAULT if look == "default" else TUNED).marker,
                color=INKS[look],
                markersize=4,
                zorder=4,
            )
        ends = f"{significant(row['low'], 3)}–{significant(row['high'], 3)} {row['unit']}, {row['scale']}"
        ax.text(0.0, i - 0.3, f"{row['name']}: {significant(row['inferred'], 3)}  ({ends})", fontsize=7, va="bottom")
    ax.set_xlim(-0.03, 1.03)
    ax.set_ylim(len(rows) - 0.5, -0.8)
    ax.set_yticks([])
    ax.set_xticks([0.0, 1.0], ["low", "high"])
    near = f"{100 * document['settings']['near']:g} %"
    ax.set_xlabel(f"range searched. Blue: within {near} of the least\nmisfit. Green: what one draw leaves open (68 %)")


def _unit(row: Document, value: float) -> float:
    """Return where a value stands in the range of its unknown, 0 to 1 on its scale."""
    from objectives.decisions import Variable

    return Variable(row["name"], (), row["low"], row["high"], row["scale"]).unit(value)
