"""A figure of a paper as plain data: panels, and how they stand on the page. Nothing here knows how it is drawn."""

from collections.abc import Sequence
from typing import NamedTuple

from tuner.report.charts.chart import Panel

WIDTH = 7.1
"""Text width of a two-column page [in]."""


class FigureSpec(NamedTuple):
    """Panels in reading order, so many columns of them; height of a row and width of the figure [in].

    legend: of all panels above the figure, unless panels have their own. titled: panels are headed by their titles. small: axes
    have small type and few numbers. note: at the foot.
    """

    panels: Sequence[Panel]
    columns: int
    height: float
    width: float = WIDTH
    legend: bool = True
    titled: bool = False
    small: bool = False
    note: str = ""
