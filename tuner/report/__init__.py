"""The report of a results folder: one offline HTML page, and figures for a paper.

Both read nothing but the folder. Drawing code is imported on use: matplotlib alone takes half a second.
"""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tuner.documents.tuning import TuningFolder
    from tuner.report.drawing import FigureProcess


def prepare() -> None:
    """Import what `write_report` takes."""
    from tuner.report import sheets as sheets
    from tuner.report import tuning_page as tuning_page


def opened(folder: Path) -> "TuningFolder":
    """Return a results folder, each of whose files is read once, when it is asked for; StoreError as in `write_report`."""
    from tuner.documents.tuning import TuningFolder

    return TuningFolder(folder)


def write_report(folder: Path, results: "TuningFolder | None" = None) -> Path:
    """Write report.html into a results folder and return its path; StoreError names a missing or damaged file.

    results: the folder, where it is opened already.
    """
    from tuner.report.page import put_page
    from tuner.report.tuning_page import tuning_page

    results = results or opened(folder)
    return put_page(results.home, tuning_page(results))


def start_figures(folder: Path) -> "FigureProcess":
    """Make ready to write figures/ like `write_figures` and return at once; tell it to `begin` and to `go_on`, then `wait`."""
    from tuner.report.drawing import FigureProcess

    return FigureProcess(folder)


def write_figures(folder: Path) -> list[Path]:
    """Write figures/*.png and *.pdf into a results folder and return their paths; StoreError as in `write_report`."""
    from tuner.report.figures import write_all

    return write_all(folder)
