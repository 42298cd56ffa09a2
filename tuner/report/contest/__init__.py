"""The report of a contest: an offline HTML page, figures for a paper; they read nothing but the folder."""

from pathlib import Path


def write_contest_report(folder: Path) -> Path:
    """Write report.html into a contest folder and return its path; StoreError names a missing or damaged file."""
    from tuner.documents.contest import open_compared
    from tuner.report.contest.page import contest_page
    from tuner.report.page import put_page

    return put_page(folder, contest_page(open_compared(folder)))


def write_contest_figures(folder: Path) -> list[Path]:
    """Write figures/*.png and *.pdf into a contest folder and return their paths; StoreError as in the report."""
    from tuner.report.contest.figures import write_all

    return write_all(folder)


def write_comparison_figures(folder: Path) -> list[Path]:
    """Write the figures of a comparison, those of a contest and the values, and return their paths."""
    from tuner.report.contest.figures import write_all

    return write_all(folder, values=True)
