"""What all figures for a paper share: size, type, marks and colours, and how they are saved.

The colours stay apart for colour-blind eyes and in grey; shapes and dashes say the same.
"""

from io import BytesIO
from math import ceil
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure

from tuner.store.folder import put

COLOURS = {
    "default": "#b4530a",
    "tuned": "#0b63a5",
    "front": "#2f7d6d",
    "grey": "#9aa3ab",
    "ink": "#2b3238",
    "bad": "#a3262a",
}
MARKERS = {"default": "s", "tuned": "D", "front": "o"}
DASHES = {"default": (0, (4, 2)), "tuned": "solid"}
# Text width of a two-column page [in], and resolution of the PNG [dots/in].
WIDTH, DPI = 7.1, 200
# Room that an entry of a legend takes: the mark with its gaps, a letter, and a row [in].
LEGEND_MARK, LEGEND_LETTER, LEGEND_ROW = 0.55, 0.05, 0.16
STYLE: dict[Any, Any] = {
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "axes.linewidth": 0.6,
    "axes.edgecolor": COLOURS["ink"],
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e7ea",
    "grid.linewidth": 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    # Text stays text in the PDF (TrueType), as journals ask.
    "pdf.fonttype": 42,
}


def style() -> Any:
    """Return the context in which figures are drawn and saved."""
    return rc_context(STYLE)


def grid(count: int, columns: int, height: float, width: float = WIDTH) -> tuple[Figure, list[Axes]]:
    """Return a figure with so many axes in reading order; height of a row and width of the figure [in]."""
    rows = ceil(count / columns)
    figure = Figure(figsize=(width, height * rows), layout="constrained")
    FigureCanvasAgg(figure)
    axes = list(figure.subplots(rows, columns, squeeze=False).flat)
    for unused in axes[count:]:
        unused.set_visible(False)
    return figure, axes[:count]


def legend_above(figure: Figure, ax: Axes) -> None:
    """Put one legend for the whole figure above it, in as many columns as fit."""
    handles, labels = ax.get_legend_handles_labels()
    widths = [LEGEND_MARK + LEGEND_LETTER * len(label) for label in labels]
    room = float(figure.get_size_inches()[0])
    columns = len(labels) if sum(widths) <= room else max(int(room / max(widths)), 1)
    width, height = figure.get_size_inches()
    figure.set_size_inches(width, height + LEGEND_ROW * (ceil(len(labels) / columns) - 1))
    figure.legend(handles, labels, loc="outside upper center", ncols=columns)


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write NAME.png and NAME.pdf into a results folder, each whole or not at all; return both paths."""
    return [put(folder, name + ending, content) for ending, content in printed(figure).items()]


def printed(figure: Figure) -> dict[str, bytes]:
    """Return a figure as ".png" and ".pdf", without a date so that the same results give the same bytes.

    Printed by the canvases themselves, because `Figure.savefig` draws everything a second time for its bounding box.
    What was laid out for the first file stands for the second.
    """
    png, pdf = BytesIO(), BytesIO()
    figure.set_dpi(DPI)
    FigureCanvasAgg(figure).print_png(png)
    figure.set_layout_engine("none")
    FigureCanvasPdf(figure).print_pdf(pdf, metadata={"CreationDate": None})
    return {".png": png.getvalue(), ".pdf": pdf.getvalue()}
