"""The figure of tails: a panel for each event."""

from pathlib import Path

from tuner.documents.tail import TailDocument
from tuner.report.charts.files import save
from tuner.report.charts.paper import Figure, figure_of, style
from tuner.report.charts.tails import document_panels
from tuner.report.sheets import TAIL_COLUMNS, TAIL_HEIGHT


def write_tail_figure(document: TailDocument, folder: Path) -> list[Path]:
    """Write tail.png and tail.pdf into a folder and return their paths."""
    with style():
        return save(tail_figure(document), folder, "tail")


def tail_figure(document: TailDocument) -> Figure:
    """Return the chart: a panel for each event, a line and a band for each of the gains."""
    panels = document_panels(document)
    return figure_of(panels, min(len(panels), TAIL_COLUMNS), TAIL_HEIGHT, titled=True)
