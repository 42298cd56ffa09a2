"""Figures for a paper: those of `tuner.report.sheets`, drawn."""

from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from plant.errors import InputError
from plant.output_files import replace_file
from tuner.documents.tuning import TuningFolder
from tuner.report.charts.paper import DPI, Figure, drawn, files_of, style
from tuner.report.sheets import flown_sheet, front_sheet, progress_sheet, scenario_sheets, search_sheets
from tuner.store.folder import put_together

if TYPE_CHECKING:
    from tuner.analysis.responses import Responses

ENDINGS = (".png", ".pdf", ".svg")


def write_all(folder: Path) -> list[Path]:
    """Write every figure that the folder has data for and return the files."""
    results = TuningFolder(folder)
    files = files_of(search_sheets(results))
    for name, sheet in scenario_sheets(results).items():
        files |= files_of({name: sheet()})
    return put_together(folder, files)


def scenario_figures(results: TuningFolder) -> dict[str, Callable[[], Figure]]:
    """Return drawers of responses and spectra in every scenario, by names of figures."""
    return {name: lambda sheet=sheet: drawn(sheet()) for name, sheet in scenario_sheets(results).items()}


def front_figure(results: TuningFolder) -> Figure:
    """Return the front, see `front_sheet`."""
    return drawn(front_sheet(results))


def progress_figure(results: TuningFolder) -> Figure:
    """Return the progress of the search, see `progress_sheet`."""
    return drawn(progress_sheet(results))


def write_responses(responses: "Responses", scenario: str, file: Path) -> None:
    """Write the fans of one controller, see `write_figure`."""
    check_ending(file)
    with style():
        write_figure(flown_figure(responses, scenario), file)


def check_ending(file: Path) -> None:
    """Refuse a figure's file of another format."""
    if file.suffix.lower() not in ENDINGS:
        raise InputError(f"given '{file}'; allowed endings: {', '.join(ENDINGS)}", key="--plot")


def write_figure(figure: Figure, file: Path) -> None:
    """Write a figure; the ending of the file decides the format. InputError where it cannot be."""
    check_ending(file)
    content = BytesIO()
    figure.savefig(content, dpi=DPI, format=file.suffix[1:].lower())
    try:
        replace_file(file, content.getvalue())
    except OSError as error:
        raise InputError(f"{file} cannot be written ({error.strerror})", key="--plot") from error


def flown_figure(responses: "Responses", scenario: str) -> Figure:
    """Return the fans of one controller, see `flown_sheet`."""
    return drawn(flown_sheet(responses, scenario))
