"""The reports of a contest and of an inference: an offline HTML page, figures for a paper; they read nothing but the folder."""

from pathlib import Path


def write_contest_report(folder: Path) -> Path:
    """Write report.html into a contest folder and return its path; StoreError names a missing or damaged file."""
    from tuner.report.contest.page import write_contest_page

    return write_contest_page(folder)


def write_contest_figures(folder: Path) -> list[Path]:
    """Write figures/*.png and *.pdf into a contest folder and return their paths; StoreError as in the report."""
    from tuner.report.contest.figures import write_all

    return write_all(folder)


def write_comparison_figures(folder: Path) -> list[Path]:
    """Write the figures of a comparison, those of a contest and the values, and return their paths."""
    from tuner.report.contest.figures import write_all, write_values_figure

    return [*write_values_figure(folder), *write_all(folder)]


def write_inference_figures(folder: Path) -> list[Path]:
    """Write figures/*.png and *.pdf into the folder of an inference and return their paths; StoreError as in the report."""
    from tuner.report import inference_figure

    return inference_figure.write_inference_figures(folder)


def write_inference_report(folder: Path) -> Path:
    """Write report.html into the folder of an inference and return its path; StoreError names what is missing."""
    from tuner.report.contest.inference_page import write_inference_page

    return write_inference_page(folder)
