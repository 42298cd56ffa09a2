"""The report of a comparison: an offline HTML page, figures for a paper; they read nothing but the folder."""

from pathlib import Path


def write_comparison_report(folder: Path) -> Path:
    """Write report.html into a folder and return its path; StoreError names a missing or damaged file."""
    from tuner.documents.comparison import ComparisonFolder
    from tuner.report.comparison.page import comparison_page
    from tuner.report.page import put_page

    return put_page(folder, comparison_page(ComparisonFolder(folder)))


def write_comparison_figures(folder: Path) -> list[Path]:
    """Write figures/*.png and *.pdf into a folder and return their paths; StoreError as in the report."""
    from tuner.documents.comparison import ComparisonFolder
    from tuner.report.comparison.figures import FIGURES, values_figure, write_all

    return write_all(ComparisonFolder(folder), {"values": values_figure, **FIGURES})
