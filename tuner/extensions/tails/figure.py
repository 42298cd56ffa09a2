"""The figure of tails: a panel for each event."""

from pathlib import Path

from tuner.api.figures import Drawers
from tuner.extensions.tails.document import TailDocument
from tuner.extensions.tails.panels import document_panels
from tuner.report.charts.files import save
from tuner.report.charts.paper import Figure, figure_of, style
from tuner.report.sheets import ADDED_COLUMNS, ADDED_HEIGHT


def figures_of(document: TailDocument) -> Drawers:
    """Return the figures of a tail by name."""
    return {"tail": lambda: tail_figure(document)}


def write_tail_figure(document: TailDocument, folder: Path) -> list[Path]:
    """Write tail.png and tail.pdf into a folder and return their paths."""
    with style():
        return save(tail_figure(document), folder, "tail")


def tail_figure(document: TailDocument) -> Figure:
    """Return the chart: a panel for each event, a line and a band for each of the gains."""
    panels = document_panels(document)
    return figure_of(panels, min(len(panels), ADDED_COLUMNS), ADDED_HEIGHT, titled=True)
