"""Figures for a paper: front, responses and progress of a results folder, as PNG and PDF."""

import re
from pathlib import Path

from tuner.documents.loading import load
from tuner.report.figure_style import printed, style
from tuner.report.front_figure import front_figure
from tuner.report.progress_figure import progress_figure
from tuner.report.responses_figure import response_figure
from tuner.store.folder import put


def write_all(folder: Path) -> list[Path]:
    """Write every figure that the folder has data for and return the files."""
    return [put(folder, name, content) for name, content in draw_all(folder).items()]


def draw_all(folder: Path) -> dict[str, bytes]:
    """Return every figure that the folder has data for, by its name in the folder."""
    results = load(folder)
    with style():
        drawn = {"front": front_figure(results), "progress": progress_figure(results)}
        for name, scenario in zip(response_names(results.scenarios), results.scenarios, strict=True):
            drawn[name] = response_figure(results, scenario)
        return {
            f"figures/{name}{ending}": content
            for name, figure in drawn.items()
            for ending, content in printed(figure).items()
        }


def response_names(scenarios: list[str]) -> list[str]:
    """Return file names for the responses: "responses" alone, or with the scenario's name, made safe and unique."""
    if len(scenarios) == 1:
        return ["responses"]
    names: list[str] = []
    for i, scenario in enumerate(scenarios):
        name = "responses-" + (re.sub(r"[^A-Za-z0-9]+", "-", scenario).strip("-") or str(i))
        names.append(f"{name}-{i}" if name in names else name)
    return names
