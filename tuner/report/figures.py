"""Figures for a paper: front, responses and progress of a results folder, as PNG and PDF."""

import re
from pathlib import Path

from plant.errors import StoreError
from tuner.report.figure_style import save, style
from tuner.report.front_figure import front_figure
from tuner.report.loading import load
from tuner.report.progress_figure import progress_figure
from tuner.report.responses_figure import response_figure


def write_all(folder: Path) -> list[Path]:
    """Write every figure that the folder has data for and return the files."""
    results = load(folder)
    target = folder / "figures"
    try:
        target.mkdir(exist_ok=True)
    except OSError as error:
        raise StoreError(f"{target} cannot be made ({error.strerror})") from error
    with style():
        drawn = {"front": front_figure(results), "progress": progress_figure(results)}
        for name, scenario in zip(response_names(results.scenarios), results.scenarios, strict=True):
            drawn[name] = response_figure(results, scenario)
        return [file for name, figure in drawn.items() for file in save(figure, target / name)]


def response_names(scenarios: list[str]) -> list[str]:
    """Return file names for the responses: "responses" alone, or with the scenario's name, made safe and unique."""
    if len(scenarios) == 1:
        return ["responses"]
    names: list[str] = []
    for i, scenario in enumerate(scenarios):
        name = "responses-" + (re.sub(r"[^A-Za-z0-9]+", "-", scenario).strip("-") or str(i))
        names.append(f"{name}-{i}" if name in names else name)
    return names
